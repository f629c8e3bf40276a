// Two frames one above the other: a new table is read by the hidden one, which then takes the place of the other, with its sliders where they were.
window.sitsDraw = (html, kind) => {
  const box = document.getElementById("sits-frames"), shown = box.querySelector("iframe.shown"), next = document.createElement("iframe");
  const kept = {};
  if (shown) for (const node of shown.contentDocument.querySelectorAll("input[type=range], select")) kept[node.id] = node.value;
  for (const old of box.querySelectorAll("iframe:not(.shown)")) old.remove();
  next.title = "sensor, curves and maps";
  next.addEventListener("load", () => {
    const page = next.contentDocument;
    for (const [id, value] of Object.entries(kept)) {
      const node = page.getElementById(id);
      if (node && node.value !== value) { node.value = value; node.dispatchEvent(new Event(node.tagName === "SELECT" ? "change" : "input")); }
    }
    for (const old of box.querySelectorAll("iframe.shown")) old.remove();
    next.className = "shown " + kind;
  });
  next.srcdoc = html;
  box.appendChild(next);
};
