"use strict";
// The teacher's page: a tile for each seat.

const AT_ONCE = 4; // images under way at the same time
const PAUSES = { running: 500, paused: 2000, stopped: 2000, busy: 3000, starting: 1000 }; // milliseconds, by state

const tiles = new Map(); // number of a seat to its tile
let links = null;

function makeTile(seat) {
  const tile = document.getElementById("seat").content.firstElementChild.cloneNode(true);
  tile.id = `seat-${seat.number}`;
  tile.querySelector(".number").textContent = seat.number;
  tile.querySelector(".open").href = `/seat/${seat.number}`;
  tile.querySelector("img").alt = `Scene of seat ${seat.number}`;
  tile.querySelector(".copy").addEventListener("click", event => tried(async () => {
    const found = (await allLinks()).find(each => each.number === seat.number);
    await copy(found.link, event.target);
  }));
  twice(tile.querySelector(".reset"), "Reset it?", () => post(`/seat/${seat.number}/reset`));
  document.getElementById("seats").append(tile);
  const kept = { element: tile, number: seat.number, state: "starting", isSeen: false, due: 0, isLoading: false };
  tiles.set(seat.number, kept);
  seen.observe(tile);
  return kept;
}

const seen = new IntersectionObserver(entries => {
  for (const entry of entries) {
    const number = Number(entry.target.id.slice("seat-".length));
    tiles.get(number).isSeen = entry.isIntersecting;
  }
});

async function allLinks() {
  links ??= await fetchJson("/links");
  return links;
}

function count(seats, test) {
  return seats.filter(test).length;
}

async function look() {
  const found = await fetchJson("/class");
  document.getElementById("scene").textContent = found.scene;
  document.getElementById("seats").classList.toggle("many", found.seats.length > 12);
  document.title = `Class ${found.scene}`;
  for (const seat of found.seats) {
    const tile = tiles.get(seat.number) ?? makeTile(seat);
    if (tile.state !== seat.state) tile.due = 0;
    tile.state = seat.state;
    // A student may have loaded another scene.
    const other = seat.scene && seat.scene !== found.scene ? ` (${seat.scene})` : "";
    tile.element.querySelector(".student").textContent = seat.student + other;
    show(tile.element, seat);
  }
  const parts = [
    `${found.seats.length} seats`,
    `${count(found.seats, seat => seat.connected > 0)} connected`,
    `${count(found.seats, seat => seat.state === "running")} running`,
  ];
  const bad = count(found.seats, seat => seat.state === "busy" || seat.state === "starting");
  if (bad) parts.push(`${bad} not ready`);
  document.getElementById("counts").textContent = parts.join(" · ");
}

// Loads images of the tiles that can be seen, the one that waits longest first.
function draw() {
  if (document.hidden) return;
  const now = performance.now();
  const all = [...tiles.values()];
  let free = AT_ONCE - all.filter(tile => tile.isLoading).length;
  const due = all.filter(tile => tile.isSeen && !tile.isLoading && tile.due <= now).sort((a, b) => a.due - b.due);
  for (const tile of due.slice(0, Math.max(0, free))) {
    tile.isLoading = true;
    nextImage(tile.element.querySelector("img"), tile.number, "small").then(() => {
      tile.isLoading = false;
      tile.due = performance.now() + PAUSES[tile.state];
    });
  }
}

document.getElementById("links").addEventListener("click", () => tried(async () => {
  const rows = await allLinks();
  const list = document.getElementById("list");
  list.value = rows.map(row => `${row.number}\t${row.student ? row.student + "\t" : ""}${row.link}`).join("\n");
  document.getElementById("all-links").showModal();
  list.scrollTop = 0;
}));
document.getElementById("copy-all").addEventListener("click", event => copy(document.getElementById("list").value, event.target));
document.getElementById("close").addEventListener("click", () => document.getElementById("all-links").close());
twice(document.getElementById("reset-all"), "Reset every seat?", () => post("/reset"));

repeat(look, STATE_EVERY);
setInterval(draw, 100);
