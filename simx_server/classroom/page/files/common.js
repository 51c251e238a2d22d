"use strict";
// What both pages share. All texts that come from seats are set as text, never as HTML.

const STATE_EVERY = 1000; // milliseconds between two looks at the states
const SILENCE = 5000; // after which the page says that the class does not answer
const LONGEST = 15000; // for an answer

async function fetchJson(path) {
  const answer = await fetch(path, { signal: AbortSignal.timeout(LONGEST) });
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
}

async function post(path) {
  const answer = await fetch(path, { method: "POST", signal: AbortSignal.timeout(LONGEST) });
  if (!answer.ok) throw new Error(await answer.text());
}

function trouble(text) {
  const place = document.getElementById("trouble");
  place.textContent = text;
  place.hidden = !text;
}

// Does what a button is for; says why it could not be done, until the next press.
async function tried(work) {
  try { await work(); trouble(""); } catch (error) { trouble(error.message); }
}

// Calls an asynchronous function again and again while somebody looks at the page.
async function repeat(work, pause) {
  let good = performance.now();
  let isTold = false;
  for (;;) {
    if (!document.hidden) {
      try {
        await work();
        good = performance.now();
        if (isTold) trouble("");
        isTold = false;
      } catch (error) {
        if (performance.now() - good > SILENCE || error.name !== "TypeError") {
          trouble("The class does not answer: " + error.message);
          isTold = true;
        }
      }
    } else {
      good = performance.now();
    }
    await new Promise(done => setTimeout(done, pause));
  }
}

function ago(seconds) {
  if (seconds < 60) return Math.max(1, Math.round(seconds)) + " s ago";
  if (seconds < 3600) return Math.round(seconds / 60) + " min ago";
  return Math.round(seconds / 3600) + " h ago";
}

// Shows a seat's state in its tile.
function show(tile, seat) {
  tile.classList.toggle("running", seat.state === "running");
  tile.classList.toggle("busy", seat.state === "busy");
  const state = seat.state === "busy" ? `busy for ${Math.round(seat.silent)} s` : seat.state;
  tile.querySelector(".state").textContent = seat.state === "running" ? `running, ${seat.time.toFixed(0)} s` : state;
  const clients = tile.querySelector(".clients");
  const names = seat.clients.map(client => client.name + (client.reads ? ", only reads" : ""));
  if (seat.program) names.unshift(`editor: ${seat.program.name} runs for ${seat.program.seconds.toFixed(0)} s`);
  if (seat.connected > seat.clients.length) names.push(`${seat.connected - seat.clients.length} more`);
  clients.textContent = names.length ? names.join("; ") : "no program connected";
  clients.classList.toggle("connected", names.length > 0);
  const problem = tile.querySelector(".problem");
  const wasReset = seat.note === "the seat was reset";
  const isNote = seat.note && !(wasReset && seat.note_ago > 60) && (seat.error_ago === null || seat.note_ago <= seat.error_ago);
  const isFault = isNote && !wasReset;
  const [text, seconds] = isNote ? [seat.note, seat.note_ago] : [seat.error, seat.error_ago];
  const image = seat.problem ? `no image: ${seat.problem}` : "";
  problem.textContent = text ? `${ago(seconds)}: ${text}` : image;
  problem.title = problem.textContent;
  problem.classList.toggle("error", isNote ? isFault : !!(seat.error || image));
  problem.classList.toggle("note", !!isNote && !isFault);
}

// Loads the next image of a seat; resolves when it is there or could not be made.
function nextImage(image, number, size) {
  return new Promise(done => {
    const end = isThere => { clearTimeout(timer); image.onload = image.onerror = null; image.classList.toggle("shown", isThere); done(isThere); };
    const timer = setTimeout(() => end(false), LONGEST);
    image.onload = () => end(true);
    image.onerror = () => end(false);
    image.src = `/seat/${number}/image?size=${size}&at=${Date.now()}`;
  });
}

// A button that has to be pressed twice.
function twice(button, question, work) {
  const text = button.textContent;
  let timer = 0;
  const calm = () => { clearTimeout(timer); timer = 0; button.textContent = text; button.classList.remove("sure"); };
  button.addEventListener("click", async () => {
    if (!timer) {
      button.textContent = question;
      button.classList.add("sure");
      timer = setTimeout(calm, 4000);
      return;
    }
    calm();
    button.disabled = true;
    await tried(work);
    setTimeout(() => { button.disabled = false; }, 2000);
  });
}

// Copies a text, also in a page without encryption, where the newer way is missing.
async function copy(text, button) {
  let isDone = false;
  try {
    await navigator.clipboard.writeText(text);
    isDone = true;
  } catch {
    const area = document.createElement("textarea");
    area.value = text;
    (document.querySelector("dialog[open]") || document.body).append(area);
    area.select();
    isDone = document.execCommand("copy");
    area.remove();
  }
  const before = button.textContent;
  button.textContent = isDone ? "Copied" : "Mark and copy it yourself";
  setTimeout(() => { button.textContent = before; }, 1500);
}
