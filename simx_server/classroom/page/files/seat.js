"use strict";
// A student's page: one seat, and the lines to paste.

const number = Number(location.pathname.split("/")[2]);
const tile = document.querySelector(".seat");
const PAUSES = { running: 200, paused: 1000, stopped: 1000, busy: 3000, starting: 1000 }; // milliseconds, by state
let state = "starting";

async function look() {
  const seat = await fetchJson(`/seat/${number}/state`);
  document.getElementById("number").textContent = number;
  document.getElementById("scene").textContent = seat.scene;
  document.getElementById("student").textContent = seat.student;
  document.title = `Seat ${number} ${seat.student}`;
  state = seat.state;
  show(tile, seat);
}

async function draw() {
  const image = tile.querySelector("img");
  image.alt = `Scene of seat ${number}`;
  for (;;) {
    if (!document.hidden && !tile.classList.contains("in-3d")) await nextImage(image, number, "large");
    await new Promise(done => setTimeout(done, PAUSES[state]));
  }
}

function choose(kind, lines) {
  for (const tab of document.getElementById("kinds").children) tab.setAttribute("aria-selected", tab.textContent === kind);
  document.getElementById("lines").replaceChildren(...lines[kind].map(line => {
    const item = document.createElement("li");
    const code = document.createElement("code");
    const button = document.createElement("button");
    code.textContent = line;
    button.textContent = "Copy";
    button.addEventListener("click", () => copy(line, button));
    item.append(code, button);
    return item;
  }));
}

async function offerLines() {
  const lines = await fetchJson(`/seat/${number}/lines`);
  document.getElementById("kinds").append(...Object.keys(lines).map(kind => {
    const tab = document.createElement("button");
    tab.setAttribute("role", "tab");
    tab.textContent = kind;
    tab.addEventListener("click", () => choose(kind, lines));
    return tab;
  }));
  choose(navigator.userAgent.includes("Windows") ? "Windows" : "Linux, macOS", lines);
}

twice(document.getElementById("reset"), "Reset it?", () => post(`/seat/${number}/reset`));
offerLines().catch(error => trouble(error.message));
repeat(look, STATE_EVERY);
draw();
