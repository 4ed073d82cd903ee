// Shows the head of a button in 3D, in its place. Pages are opened from disk, where browsers load scripts but no other
// files: so the viewer and every head are scripts, and a head is its GLB, compressed, as text.
"use strict";

const heads = {};

function load(path) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.onload = resolve;
    script.onerror = () => reject(new Error(path + " is missing"));
    script.src = path;
    document.head.append(script);
  });
}

async function unpacked(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Blob([await new Response(stream).arrayBuffer()], { type: "model/gltf-binary" });
}

async function turn(button) {
  button.disabled = true;
  button.textContent = "loading";
  try {
    if (!customElements.get("model-viewer")) await load(button.dataset.viewer);
    await load(button.dataset.head);
    const viewer = document.createElement("model-viewer");
    viewer.setAttribute("camera-controls", "");
    viewer.setAttribute("loading", "eager");
    viewer.setAttribute("camera-orbit", "20deg 85deg auto");
    viewer.setAttribute("alt", button.dataset.name);
    viewer.setAttribute("interaction-prompt", "none");
    viewer.src = URL.createObjectURL(await unpacked(heads[button.dataset.head]));
    delete heads[button.dataset.head];
    button.replaceWith(viewer);
  } catch (error) {
    button.textContent = "cannot be shown: " + error.message;
  }
}

document.addEventListener("click", (event) => {
  if (event.target.matches("button.turn")) turn(event.target);
});
