// Before all other parts of the page are there: no module, so that it runs without them.

// A file that is dropped while the page still loads does not take its place.
for (const kind of ["dragover", "drop"]) addEventListener(kind, (event) => event.preventDefault());

// One file that is missing keeps all modules from running. Errors of elements do not rise to the window: they are caught
// on their way down.
addEventListener("error", ({ target }) => {
  if (!target.matches?.("script[type=module]")) return;
  document.getElementById("loading").textContent = location.protocol === "file:"
    ? "This page needs a file server: scripts/web --serve is one." : "A part of the page did not come: open it again.";
}, true);
