"use strict";
// The 3-D view with the time slider: a page of its own in a frame, which the server starts when it is wanted.

const frame = document.getElementById("view");
const tabs = { view: document.getElementById("show-view"), image: document.getElementById("show-image") };
let isIn3d = false; // the view is wanted and was started

function chooseTab(name) {
  for (const [each, tab] of Object.entries(tabs)) tab.setAttribute("aria-selected", each === name);
}

async function showView() {
  chooseTab("view");
  document.getElementById("view-hint").textContent = "";
  try {
    const place = await postJson(`/seat/${number}/view`);
    frame.src = `${location.protocol}//${location.hostname}:${place.port}/?token=${place.token}`;
    frame.hidden = false;
    isIn3d = true;
    tile.classList.add("in-3d");
  } catch (error) {
    showImage();
    document.getElementById("view-hint").textContent = error.message;
  }
}

function showImage() {
  chooseTab("image");
  isIn3d = false;
  frame.hidden = true;
  frame.removeAttribute("src");
  tile.classList.remove("in-3d");
}

tabs.view.addEventListener("click", showView);
tabs.image.addEventListener("click", showImage);

// Whether the server still has the view, as each look at the output reports.
function noteView(runs) {
  if (isIn3d && !runs) showView();
}
