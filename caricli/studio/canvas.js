// Lines are drawn here at once; the server hears of a stroke when it is done.
const NEAR = 1.2; // pixels of the canvas between points of a stroke
const WIDTH = 2.2; // pixels of a canvas of 512, a line at medium pressure

export default {
  template: `
    <div class="caricli-canvas">
      <div class="caricli-sheet" :style="shape">
        <img v-if="underlay" :src="underlay" alt="" draggable="false" />
        <canvas ref="sheet" :width="width" :height="height" role="img" :aria-label="label"></canvas>
      </div>
    </div>`,
  props: { width: Number, height: Number, label: String, underlay: String, drawn: String, rubbed: String },
  computed: {
    // As large as there is room for.
    shape() {
      const { width, height } = this;
      return { aspectRatio: `${width} / ${height}`, width: `min(100cqw, ${(100 * width) / height}cqh)` };
    },
    // How much finer the canvas is than one of 512 pixels, which widths are told of.
    finer() {
      return Math.max(1, this.width / 512, this.height / 512);
    },
  },
  mounted() {
    this.lines = [];
    this.waiting = []; // strokes that the server has not heard of or answered yet
    this.tool = "draw";
    this.radius = 10;
    this.ink();
    const canvas = this.$refs.sheet;
    canvas.addEventListener("pointerdown", (event) => this.begin(event));
    canvas.addEventListener("pointermove", (event) => this.go(event));
    canvas.addEventListener("pointerup", (event) => this.end(event));
    canvas.addEventListener("pointercancel", (event) => this.cancel(event));
    new MutationObserver(() => this.redraw()).observe(document.body, { attributeFilter: ["class"] });
    this.$emit("ready");
  },
  watch: {
    shape() {
      this.$nextTick(() => this.redraw()); // another size empties a canvas
    },
  },
  methods: {
    ink() {
      this.colour = this.underlay ? "#c2185b" : getComputedStyle(this.$refs.sheet).color;
    },
    place(event) {
      const box = this.$refs.sheet.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * this.width - 0.5;
      const y = ((event.clientY - box.top) / box.height) * this.height - 0.5;
      return [Math.round(100 * x) / 100, Math.round(100 * y) / 100];
    },
    begin(event) {
      const pen = event.pointerType === "pen";
      this.penned ||= pen;
      // Beside a pen what touches is the hand that holds it: it draws nothing, and gives way where it came first.
      const palm = event.pointerType === "touch" && this.penned;
      if (event.button || palm || (this.stroke && (!pen || this.stroke.pen))) return;
      event.preventDefault();
      this.$refs.sheet.setPointerCapture(event.pointerId);
      this.stroke = { id: event.pointerId, points: [], pressure: [], pen };
      this.add(event);
      this.redraw();
    },
    go(event) {
      if (this.stroke?.id !== event.pointerId) return;
      for (const each of event.getCoalescedEvents?.().length ? event.getCoalescedEvents() : [event]) this.add(each);
    },
    add(event) {
      const stroke = this.stroke;
      const point = this.place(event);
      const last = stroke.points.at(-1);
      if (last && Math.hypot(point[0] - last[0], point[1] - last[1]) < NEAR) return;
      stroke.points.push(point);
      stroke.pressure.push(Math.round(1000 * event.pressure) / 1000);
      if (this.tool === "draw") this.trace(stroke, stroke.points.length - 2);
      else this.rub(stroke, stroke.points.length - 2);
    },
    end(event) {
      if (this.stroke?.id !== event.pointerId) return;
      const { points, pressure, pen } = this.stroke;
      this.stroke = null;
      const parameters = { points };
      if (this.tool === "erase") parameters.radius = this.radius * this.finer;
      else if (pen) parameters.pressure = pressure.map((each) => Math.min(1, each));
      this.$refs.sheet.dataset.lifted = performance.now();
      const operation = { name: this.tool === "draw" ? this.drawn : this.rubbed, parameters };
      this.waiting.push({ operation, points, pressure: pen ? pressure : null });
      window.caricliKeep?.pend(operation);
      this.$emit("operation", operation);
    },
    // What the browser takes for a palm, or for a gesture of its own.
    cancel(event) {
      if (this.stroke?.id !== event.pointerId) return;
      this.stroke = null;
      this.redraw();
    },
    pen() {
      const pen = this.$refs.sheet.getContext("2d");
      pen.lineCap = pen.lineJoin = "round";
      pen.strokeStyle = this.colour;
      pen.globalCompositeOperation = "source-over";
      return pen;
    },
    // A line from a number of its points on, or the whole of it.
    trace({ points, pressure, pen: felt }, from = 0) {
      const pen = this.pen();
      for (let k = Math.max(from, 0); k < points.length; k++) {
        const strength = (felt || felt === undefined) && pressure ? pressure[k] : 0.5;
        pen.lineWidth = WIDTH * (0.4 + 1.2 * strength) * this.finer;
        pen.beginPath();
        pen.moveTo(points[Math.max(k - 1, 0)][0] + 0.5, points[Math.max(k - 1, 0)][1] + 0.5);
        pen.lineTo(points[k][0] + 0.5, points[k][1] + 0.5);
        pen.stroke();
      }
    },
    rub({ points }, from = 0) {
      const pen = this.pen();
      pen.globalCompositeOperation = "destination-out";
      pen.lineWidth = 2 * this.radius * this.finer;
      for (let k = Math.max(from, 0); k < points.length; k++) {
        pen.beginPath();
        pen.moveTo(points[Math.max(k - 1, 0)][0] + 0.5, points[Math.max(k - 1, 0)][1] + 0.5);
        pen.lineTo(points[k][0] + 0.5, points[k][1] + 0.5);
        pen.stroke();
      }
    },
    redraw() {
      this.ink();
      const pen = this.pen();
      pen.clearRect(0, 0, this.width, this.height);
      for (const line of this.lines) this.trace(line);
      for (const each of this.waiting) this[each.operation.name === this.rubbed ? "rub" : "trace"](each);
      if (this.stroke) this[this.tool === "draw" ? "trace" : "rub"](this.stroke);
    },
    // What the server has: all lines, and how many strokes it answered.
    show(lines, answered) {
      this.lines = lines;
      this.waiting.splice(0, answered);
      this.redraw();
      this.$refs.sheet.dataset.lines = lines.length;
    },
    use(tool, radius) {
      this.tool = tool;
      this.radius = radius ?? this.radius;
      this.$refs.sheet.style.cursor = tool === "draw" ? "crosshair" : "cell";
    },
  },
};
