// A picture with landmarks on it that a hand moves. Plain JavaScript; nothing comes from outside the machine.
// `LandmarkCanvas` knows no framework; what NiceGUI takes is the default export at the end.
//
// It tells its listener what was done, as operations of a session: ("try", {seq, name, parameters}) while a hand moves,
// ("do", {name, parameters}) when it lets go, ("forget") where it takes a try back, ("chosen", {point, label}),
// ("switch", {name}). A try is answered by `show`; no more than two are on their way, one of them under work, so that a
// slow server is never far behind.

const SVG = "http://www.w3.org/2000/svg";
const REACH = { mouse: 14, pen: 18, touch: 26 }; // pixels of the screen: how near a point a pointer must come
const LOUPE = 168; // pixels of the screen, its side
const FILLED = 0.75; // of the canvas, by a face that is small in its picture
const MAGNIFIED = 4; // times the screen's picture, in the loupe
const AHEAD = 2; // tries that are on their way
const PATIENCE = 1500; // milliseconds until a try without an answer is forgotten
const REST = 500; // milliseconds after the last key until what the keys did is one operation
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function node(name, parent, attributes = {}) {
  const svg = ["svg", "g", "circle", "path"].includes(name);
  const element = svg ? document.createElementNS(SVG, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.appendChild(element);
  return element;
}

// Attributes that stay cost nothing.
function change(element, name, value) {
  if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}

export class LandmarkCanvas {
  constructor(root, listener) {
    this.root = root;
    this.tell = listener;
    this.options = { symmetric: true, grouped: false, overlay: true };
    this.points = [];
    this.guess = [];
    this.curves = [];
    this.labels = [];
    this.updates = 0; // answers to tries, other answers, and scenes, counted for tests
    this.answers = 0;
    this.scenes = 0;
    this.seq = 0;
    this.tries = new Map(); // when those were sent that have no answer yet
    this.zoom = 1;
    this.origin = [0, 0];
    this.chosen = null;
    root.landmarks = this; // for tests
    root.classList.add("marks");
    root.setAttribute("role", "group");
    root.setAttribute("aria-label", "Landmarks on the picture");
    this.image = node("img", root, { alt: "", draggable: "false", class: "marks-picture" });
    this.sheet = node("svg", root, { class: "marks-sheet" });
    this.overlay = node("path", this.sheet, { class: "marks-face-edge" });
    this.overlayInk = node("path", this.sheet, { class: "marks-face" });
    this.joints = node("path", this.sheet, { class: "marks-joints" });
    this.dots = node("g", this.sheet);
    this.loupe = node("canvas", root, { class: "marks-loupe", width: LOUPE, height: LOUPE, "aria-hidden": "true" });
    this.words = node("div", root, { class: "marks-words", role: "status", "aria-live": "polite" });
    this.loupe.hidden = true;
    this.image.addEventListener("load", () => this.draw());
    root.addEventListener("pointerdown", (event) => this.press(event));
    root.addEventListener("pointermove", (event) => this.drag(event));
    root.addEventListener("pointerup", (event) => this.release(event));
    root.addEventListener("pointercancel", (event) => event.pointerId === this.hold?.id && this.cancel());
    root.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    root.addEventListener("keydown", (event) => this.key(event));
    // What keys did comes before what is done elsewhere; buttons that move points go on with it.
    root.addEventListener("focusout", (event) => root.contains(event.relatedTarget) || this.settle());
    const press = (event) => event.target.closest(".marks, .caricli-icons") || this.settle();
    document.addEventListener("pointerdown", press, { capture: true });
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(root);
  }

  // What is shown: src, size [width, height], labels, groups {name: [numbers]}, lines [[numbers]].
  open(scene) {
    this.scenes += 1;
    this.cancel();
    Object.assign(this, { size: scene.size, labels: scene.labels, groups: scene.groups, lines: scene.lines });
    this.partner = scene.mirrored;
    this.dots.replaceChildren();
    this.elements = this.labels.map((label, number) => {
      const dot = node("g", this.dots, { tabindex: "0", role: "button", class: "marks-dot" });
      dot.setAttribute("aria-roledescription", "landmark");
      for (const kind of ["halo", "ring", "edge", "ink"]) node("circle", dot, { class: `marks-${kind}` });
      dot.addEventListener("focus", () => this.choose(number));
      return dot;
    });
    this.points = this.guess = this.curves = [];
    this.chosen = null;
    this.unseen = true;
    this.image.src = scene.src;
    this.fit();
  }

  // An answer of the server. points: [x, y] or null; guess: where the fitted face has them; curves: its lines [[x, y]];
  // mirror: [[a, b], [c, d]], what a move is on the other side. seq: of the try it answers, or nothing.
  show(state) {
    if (state.seq !== undefined) {
      this.updates += 1;
      this.tries.delete(state.seq);
    } else {
      this.answers += 1;
    }
    this.curves = state.curves ?? this.curves;
    this.guess = state.guess ?? this.guess;
    if (!this.hold && !this.nudged) {
      this.points = state.points ?? this.points;
      this.mirror = state.mirror ?? this.mirror;
      if (this.unseen && this.points.some(Boolean)) this.frame();
    } else if (this.late) {
      this.attempt(this.late);
    }
    this.draw();
  }

  set(name, value) {
    this.options[name] = value;
    this.draw();
  }

  resize() {
    this.fit();
    if (this.points.some(Boolean)) this.frame();
    this.draw();
  }

  // The whole picture in the middle.
  fit() {
    if (!this.size) return;
    const { clientWidth, clientHeight } = this.root;
    this.zoom = Math.min(clientWidth / this.size[0], clientHeight / this.size[1]) || 1;
    this.origin = [(clientWidth - this.zoom * this.size[0]) / 2, (clientHeight - this.zoom * this.size[1]) / 2];
    this.draw();
  }

  // A face that is small in its picture, so large that its points are apart.
  frame() {
    this.unseen = false;
    const placed = this.points.filter(Boolean);
    const [low, high] = [Math.min, Math.max].map((most) => [0, 1].map((axis) => most(...placed.map((p) => p[axis]))));
    const room = [this.root.clientWidth, this.root.clientHeight];
    const zoom = Math.min(...room.map((side, axis) => (FILLED * side) / Math.max(high[axis] - low[axis], 1)));
    if (!(zoom > 1.3 * this.zoom)) return;
    this.zoom = zoom;
    this.origin = room.map((side, axis) => side / 2 - zoom * ((low[axis] + high[axis] + 1) / 2));
  }

  magnify(factor, place = [this.root.clientWidth / 2, this.root.clientHeight / 2]) {
    const zoom = Math.min(40, Math.max(0.05, this.zoom * factor));
    this.origin = this.origin.map((start, axis) => place[axis] - ((place[axis] - start) * zoom) / this.zoom);
    this.zoom = zoom;
    this.draw();
  }

  // Centres of pixels are at whole numbers.
  toScreen([x, y]) {
    return [(x + 0.5) * this.zoom + this.origin[0], (y + 0.5) * this.zoom + this.origin[1]];
  }

  toPicture([x, y]) {
    return [(x - this.origin[0]) / this.zoom - 0.5, (y - this.origin[1]) / this.zoom - 0.5];
  }

  place(number) {
    return this.points[number] ?? this.guess[number] ?? null;
  }

  draw() {
    if (!this.size || !this.elements) return;
    const { image, zoom, origin } = this;
    image.style.transform = `translate(${origin[0]}px, ${origin[1]}px) scale(${zoom})`;
    image.style.width = `${this.size[0]}px`;
    image.style.imageRendering = zoom > 3 ? "pixelated" : "auto";
    const path = (rows) => rows.map((row) => "M" + row.map((p) => this.toScreen(p).map((x) => x.toFixed(1))).join("L"));
    const curves = this.options.overlay ? path(this.curves).join("") : "";
    this.overlay.setAttribute("d", curves);
    this.overlayInk.setAttribute("d", curves);
    const parts = this.lines.map((line) => line.map((number) => this.points[number]).filter(Boolean));
    this.joints.setAttribute("d", path(parts.filter((part) => part.length > 1)).join(""));
    const together = new Set(this.options.grouped && this.chosen !== null ? this.groupOf(this.chosen)[1] : []);
    this.elements.forEach((dot, number) => {
      const place = this.place(number);
      dot.style.display = place ? "" : "none";
      if (!place) return;
      const [x, y] = this.toScreen(place);
      change(dot, "transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})`);
      dot.classList.toggle("marks-off", !this.points[number]);
      dot.classList.toggle("marks-chosen", number === this.chosen);
      dot.classList.toggle("marks-together", together.has(number));
      change(dot, "aria-label", this.say(number));
    });
    if (!this.loupe.hidden) this.look();
  }

  say(number) {
    const point = this.points[number];
    return `${this.labels[number]}, ${point ? `at ${point.map((x) => Math.round(x)).join(", ")}` : "off"}`;
  }

  groupOf(number) {
    return Object.entries(this.groups).find(([, numbers]) => numbers.includes(number));
  }

  choose(number) {
    if (this.chosen !== number) this.settle();
    this.chosen = number;
    this.tell("chosen", { point: number, label: this.say(number) });
    this.draw();
  }

  // The loupe: what is around the chosen point, in the corner that is farthest from it.
  look() {
    const place = this.place(this.chosen);
    if (!place) return;
    const [x, y] = this.toScreen(place);
    this.loupe.style.left = x > this.root.clientWidth / 2 ? "8px" : "auto";
    this.loupe.style.right = x > this.root.clientWidth / 2 ? "auto" : "8px";
    this.loupe.style.top = y > this.root.clientHeight / 2 ? "8px" : "auto";
    this.loupe.style.bottom = y > this.root.clientHeight / 2 ? "auto" : "8px";
    const scale = Math.max(MAGNIFIED * this.zoom, 3);
    const pen = this.loupe.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, LOUPE, LOUPE);
    const at = ([a, b]) => [(a - place[0]) * scale + LOUPE / 2, (b - place[1]) * scale + LOUPE / 2];
    pen.imageSmoothingEnabled = scale < 4;
    pen.drawImage(this.image, ...at([-0.5, -0.5]), this.size[0] * scale, this.size[1] * scale);
    const stroke = (trace) => {
      for (const [width, ink] of [[3, "#000c"], [1.2, "#fff"]]) {
        pen.beginPath();
        trace();
        pen.lineWidth = width;
        pen.strokeStyle = ink;
        pen.stroke();
      }
    };
    this.points.forEach((point, number) => {
      if (!point || number === this.chosen) return;
      stroke(() => pen.arc(...at(point), 3.5, 0, 7));
    });
    stroke(() => {
      for (const [dx, dy] of Object.values(KEYS)) {
        pen.moveTo(LOUPE / 2 + 5 * dx, LOUPE / 2 + 5 * dy);
        pen.lineTo(LOUPE / 2 + 22 * dx, LOUPE / 2 + 22 * dy);
      }
    });
  }

  nearest(place, reach) {
    let best = null;
    this.elements.forEach((_, number) => {
      const point = this.place(number);
      if (!point) return;
      const [x, y] = this.toScreen(point);
      const far = Math.hypot(x - place[0], y - place[1]);
      if (far <= (best ? best.far : reach)) best = { number, far };
    });
    return best && best.number;
  }

  where(event) {
    const box = this.root.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  press(event) {
    if (event.button > 1 || this.hold || !this.elements) return;
    const place = this.where(event);
    const number = event.button === 0 ? this.nearest(place, REACH[event.pointerType] ?? REACH.mouse) : null;
    this.settle();
    this.root.setPointerCapture(event.pointerId);
    event.preventDefault();
    this.hold = { id: event.pointerId, number, place, origin: this.origin, points: this.points, moved: false };
    if (number === null) return;
    this.elements[number].focus({ preventScroll: true });
    this.loupe.hidden = false;
    this.look();
  }

  drag(event) {
    const { hold } = this;
    if (hold?.id !== event.pointerId) return;
    const place = this.where(event);
    const shift = [place[0] - hold.place[0], place[1] - hold.place[1]];
    hold.moved ||= Math.hypot(...shift) > 2;
    if (!hold.moved) return;
    if (hold.number === null) {
      this.origin = [hold.origin[0] + shift[0], hold.origin[1] + shift[1]];
      this.draw();
    } else {
      this.move(hold, shift.map((x) => x / this.zoom));
    }
  }

  // Points as they are while a hand moves: the page does not wait for the server. hold: number and the points before.
  move(hold, shift) {
    const before = hold.points;
    const grouped = this.options.grouped && before[hold.number];
    const [name, members] = grouped ? this.groupOf(hold.number) : [null, [hold.number]];
    const numbers = members.filter((number) => before[number] || number === hold.number);
    this.points = [...before];
    const go = (number, [dx, dy]) => {
      const start = before[number] ?? this.guess[number];
      this.points[number] = [start[0] + dx, start[1] + dy];
    };
    const partners = numbers.map((number) => this.partner[number]).filter((number) => before[number]);
    numbers.forEach((number) => go(number, shift));
    const apart = before[hold.number] && !partners.some((number) => numbers.includes(number));
    if (this.options.symmetric && this.mirror && apart) {
      const other = this.mirror.map((row) => row[0] * shift[0] + row[1] * shift[1]);
      partners.forEach((number) => go(number, other));
    }
    const { symmetric } = this.options;
    hold.operation = grouped
      ? { name: "mark_group", parameters: { group: name, shift, symmetric } }
      : { name: "mark", parameters: { point: hold.number, place: this.points[hold.number], symmetric } };
    this.attempt(hold.operation);
    this.draw();
  }

  attempt(operation) {
    const now = performance.now();
    for (const [seq, sent] of this.tries) if (now - sent > PATIENCE) this.tries.delete(seq);
    this.late = this.tries.size < AHEAD ? null : operation;
    if (this.late) return;
    this.seq += 1;
    this.tries.set(this.seq, now);
    this.tell("try", { seq: this.seq, ...operation });
  }

  release(event) {
    const { hold } = this;
    if (hold?.id !== event.pointerId) return;
    this.hold = null;
    this.loupe.hidden = true;
    if (hold.operation) this.do(hold.operation);
  }

  cancel() {
    if (this.hold && this.hold.number !== null) this.points = this.hold.points;
    const tried = this.hold?.operation || this.nudged;
    clearTimeout(this.timer);
    this.hold = this.nudged = this.late = null;
    this.loupe.hidden = true;
    this.draw();
    if (tried) this.tell("forget", {});
  }

  // What keys did so far becomes one operation.
  settle() {
    clearTimeout(this.timer);
    const { nudged } = this;
    this.nudged = null;
    if (!nudged) return;
    this.loupe.hidden = true;
    this.do(nudged.operation);
  }

  do(operation) {
    this.late = null;
    this.words.textContent = this.say(this.chosen);
    this.tell("do", operation);
  }

  // A step of the chosen point by keys or buttons, in pixels of the picture.
  nudge(step) {
    if (this.chosen === null || !this.place(this.chosen)) return;
    this.nudged ??= { number: this.chosen, points: this.points, shift: [0, 0] };
    this.nudged.shift = this.nudged.shift.map((x, axis) => x + step[axis]);
    this.loupe.hidden = false;
    this.move(this.nudged, this.nudged.shift);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.settle(), REST);
  }

  // Off, or on again where the fitted face has it.
  toggle(off) {
    const number = this.chosen;
    if (number === null) return;
    this.settle();
    const on = Boolean(this.points[number]);
    if (on && off !== false) {
      this.points = this.points.with(number, null);
      this.do({ name: "mark_off", parameters: { points: [number] } });
    } else if (!on && off !== true && this.guess[number]) {
      this.points = this.points.with(number, this.guess[number]);
      this.do({ name: "mark", parameters: { point: number, place: this.guess[number], symmetric: false } });
    }
    this.draw();
  }

  // Turn or scale the group of the chosen point, or the whole face.
  turn(change) {
    this.settle();
    const group = this.options.grouped && this.chosen !== null ? this.groupOf(this.chosen)[0] : "face";
    this.do({ name: "mark_group", parameters: { group, symmetric: this.options.symmetric, ...change } });
  }

  wheel(event) {
    event.preventDefault();
    this.magnify(Math.exp(-event.deltaY / 400), this.where(event));
  }

  key(event) {
    const letter = event.key.toLowerCase();
    let used = true;
    if ((event.ctrlKey || event.metaKey) && (letter === "z" || letter === "y")) {
      // The page undoes; what keys did so far is the last operation.
      this.settle();
      used = false;
    } else if (event.ctrlKey || event.metaKey || event.altKey) used = false;
    else if (event.key in KEYS) this.nudge(KEYS[event.key].map((x) => x * (event.shiftKey ? 10 : 1)));
    else if (event.key === "Delete" || event.key === "Backspace") this.toggle(true);
    else if (event.key === "Enter" || event.key === " ") this.toggle(this.points[this.chosen] ? true : false);
    else if (event.key === "Escape") this.cancel();
    else if (letter === "s" || letter === "g") this.tell("switch", { name: letter === "s" ? "symmetric" : "grouped" });
    else if (event.key === "[" || event.key === "]") this.turn({ turn: event.key === "[" ? -2 : 2 });
    else if (event.key === "+" || event.key === "-") this.turn({ scale: event.key === "+" ? 1.03 : 1 / 1.03 });
    else used = false;
    if (used) {
      event.preventDefault();
      event.stopPropagation();
    }
  }
}

export default {
  template: "<div></div>",
  mounted() {
    this.canvas = new LandmarkCanvas(this.$el, (name, detail) => this.$emit(name, detail));
    this.$emit("ready", {});
  },
  methods: {
    open(scene) {
      this.canvas.open(scene);
    },
    show(state) {
      this.canvas.show(state);
    },
    set(name, value) {
      this.canvas.set(name, value);
    },
    ask(name, ...values) {
      this.canvas[name](...values);
    },
  },
};
