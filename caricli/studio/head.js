import { OrbitControls, THREE } from "nicegui-scene";

// Numbers of the eyes before the positions of a frame: centre, radius, turns about y and x, left and right.
const EYES = 12;
const CLAY = 0xd8b49a;
const HOME = new THREE.Vector3(0, 0, 0.62);

const REST = 800; // milliseconds without a change after which a head that software draws gets smooth edges

// Whether there is no graphics card, so that every pixel costs the time of the processor.
function drawnBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

function eyeball() {
  const eye = new THREE.Group();
  const part = (radius, colour, reach, rings) => {
    const cap = new THREE.SphereGeometry(radius, 24, rings, 0, 2 * Math.PI, 0, reach);
    cap.rotateX(Math.PI / 2); // the pole looks out of the face
    eye.add(new THREE.Mesh(cap, new THREE.MeshStandardMaterial({ color: colour, roughness: 0.35 })));
  };
  part(1, 0xf4f1ec, 2, 10); // as far round as lids ever open
  part(1.004, 0x4f6b5a, 0.52, 3);
  part(1.008, 0x14110f, 0.24, 2);
  return eye;
}

// Unit normals of every vertex, weighted by area.
function vertexNormals(positions, faces, normals) {
  normals.fill(0);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f];
    const b = 3 * faces[f + 1];
    const c = 3 * faces[f + 2];
    const ux = positions[b] - positions[a];
    const uy = positions[b + 1] - positions[a + 1];
    const uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a];
    const vy = positions[c + 1] - positions[a + 1];
    const vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    for (const k of [a, b, c]) {
      normals[k] += x;
      normals[k + 1] += y;
      normals[k + 2] += z;
    }
  }
  for (let k = 0; k < normals.length; k += 3) {
    const length = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
    normals[k] /= length;
    normals[k + 1] /= length;
    normals[k + 2] /= length;
  }
}

export default {
  template: `
    <div class="caricli-head">
      <canvas tabindex="0" role="img" :aria-label="label" @keydown="key"></canvas>
      <svg class="caricli-ink" aria-hidden="true"><polyline fill="none" /></svg>
      <div class="caricli-fault" role="alert" v-if="fault">{{ fault }}</div>
    </div>`,
  props: { base: String, label: String },
  data() {
    return { fault: "" };
  },
  mounted() {
    this.canvas = this.$el.querySelector("canvas");
    this.$el.caricli = this; // what tests ask
    try {
      this.stage();
    } catch (error) {
      this.fault = "This browser shows no 3D pictures (WebGL): drawing and saving work, the head stays unseen.";
      this.$emit("ready");
      return;
    }
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(this.$el);
    this.resize();
    this.$emit("ready");
  },
  unmounted() {
    this.watcher?.disconnect();
    clearTimeout(this.resting);
    this.renderer?.dispose();
  },
  methods: {
    stage() {
      this.soft = drawnBySoftware();
      this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: !this.soft, alpha: true });
      this.scene = new THREE.Scene();
      this.camera = new THREE.PerspectiveCamera(28, 1, 0.01, 10);
      this.camera.position.copy(HOME);
      this.controls = new OrbitControls(this.camera, this.canvas);
      this.controls.addEventListener("change", () => this.draw());
      this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8078, 1.6));
      const lamp = new THREE.DirectionalLight(0xffffff, 1.9);
      lamp.position.set(-0.6, 0.8, 1);
      this.camera.add(lamp);
      this.scene.add(this.camera);
      this.geometry = new THREE.BufferGeometry();
      // Skin is closed and seen from outside alone; both sides would take half as long again.
      const plain = { vertexColors: true, side: THREE.DoubleSide };
      this.materials = {
        skin: new THREE.MeshStandardMaterial({ color: CLAY, roughness: 0.62 }),
        parts: new THREE.MeshStandardMaterial({ roughness: 0.4, ...plain }),
        hair: new THREE.MeshStandardMaterial({ roughness: 0.62, ...plain }),
      };
      this.head = new THREE.Mesh(this.geometry, Object.values(this.materials));
      this.head.frustumCulled = false;
      this.eyes = [eyeball(), eyeball()];
      this.dot = new THREE.Mesh(new THREE.SphereGeometry(0.0025), new THREE.MeshBasicMaterial({ color: 0xb00020 }));
      this.dot.visible = false;
      this.scene.add(this.head, ...this.eyes, this.dot);
      this.chosen = [0x00507a, 0xb00020].map((color) => this.dots(color));
      this.canvas.addEventListener("pointerdown", (event) => this.grab(event), true);
      this.canvas.addEventListener("pointerdown", (event) => this.pen(event), true);
      this.canvas.addEventListener("pointermove", (event) => this.drag(event));
      this.canvas.addEventListener("pointermove", (event) => this.ink(event));
      this.canvas.addEventListener("pointerup", (event) => this.release(event));
      this.canvas.addEventListener("pointerup", (event) => this.lift(event));
      this.canvas.addEventListener("pointercancel", (event) => this.cancel(event));
    },
    resize() {
      const { clientWidth: width, clientHeight: height } = this.$el;
      if (!width || !height) return;
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.draw();
    },
    draw() {
      if (this.waiting) return;
      this.waiting = requestAnimationFrame(() => {
        this.waiting = 0;
        if (this.turning) {
          this.controls.autoRotate = true;
          this.controls.update();
          this.draw();
        }
        this.render();
        this.canvas.dataset.shown = this.shown ?? "";
        if (!this.soft) return;
        clearTimeout(this.resting);
        this.resting = setTimeout(() => this.render(1.5), REST);
      });
    },
    // finer: how many times the screen's pixels.
    render(finer = 1) {
      const ratio = finer * Math.min(window.devicePixelRatio, 2);
      if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
      this.renderer.render(this.scene, this.eye());
    },
    // The triangles, once and where a face of another layout is opened.
    async layout(number) {
      if (!this.renderer) return;
      const answer = await fetch(`${this.base}/layout/${number}`);
      if (!answer.ok) return;
      const data = await answer.arrayBuffer();
      const [vertices, corners, triangles, skin, hair] = new Int32Array(data, 0, 5);
      const whole = new Int32Array(data, 20, corners + 3 * triangles);
      this.owners = whole.slice(0, corners);
      const index = Uint32Array.from(whole.subarray(corners));
      this.faces = index.map((corner) => this.owners[corner]);
      this.vertices = vertices;
      this.normals = new Float32Array(3 * vertices);
      const uvs = new Float32Array(data, 20 + whole.byteLength, 2 * corners);
      const colours = new Float32Array(data, 20 + whole.byteLength + uvs.byteLength, 3 * corners);
      this.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
      this.geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
      this.geometry.setAttribute("uv", new THREE.BufferAttribute(uvs, 2));
      this.geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
      this.geometry.setIndex(new THREE.BufferAttribute(index, 1));
      this.geometry.clearGroups();
      this.skin = skin;
      const bounds = [0, skin, triangles - hair, triangles];
      for (let k = 0; k < 3; k++) this.geometry.addGroup(3 * bounds[k], 3 * (bounds[k + 1] - bounds[k]), k);
      this.shown = undefined; // its positions are still to come, even where a later frame was there before it
    },
    // Only positions, whenever the face changes; an older answer that comes later is left.
    async show(number) {
      if (!this.renderer) return;
      const answer = await fetch(`${this.base}/frame/${number}`);
      if (answer.status === 404) this.fault = "Too many tabs are open, and this one has ended: load it again.";
      if (!answer.ok) return;
      const frame = new Float32Array(await answer.arrayBuffer());
      if (this.shown !== undefined && number < this.shown) return;
      this.shown = number;
      this.eyes.forEach((eye, side) => {
        const [x, y, z, radius, aside, down] = frame.subarray(6 * side, 6 * side + 6);
        eye.position.set(x, y, z);
        eye.scale.setScalar(Math.max(radius, 1e-6));
        eye.rotation.set(down, aside, 0, "YXZ");
      });
      this.place(frame.subarray(EYES));
      this.positions = frame.slice(EYES);
      this.mark();
      if (!this.pulled) this.dot.visible = false;
      if (!this.centred) this.centre();
      this.draw();
    },
    place(positions) {
      vertexNormals(positions, this.faces, this.normals);
      const place = this.geometry.attributes.position;
      const normal = this.geometry.attributes.normal;
      for (let corner = 0; corner < this.owners.length; corner++) {
        const from = 3 * this.owners[corner];
        for (let k = 0; k < 3; k++) {
          place.array[3 * corner + k] = positions[from + k];
          normal.array[3 * corner + k] = this.normals[from + k];
        }
      }
      place.needsUpdate = true;
      normal.needsUpdate = true;
      this.geometry.boundingSphere = null;
    },
    centre() {
      this.centred = true;
      const box = new THREE.Box3().setFromArray(this.positions);
      const middle = box.getCenter(new THREE.Vector3());
      const height = box.max.y - box.min.y;
      this.controls.target.copy(middle);
      this.camera.position.set(middle.x, middle.y, middle.z + 2.75 * height);
      this.controls.update();
    },
    view(degrees) {
      const away = this.camera.position.distanceTo(this.controls.target);
      const turn = (degrees * Math.PI) / 180;
      this.camera.position.copy(this.controls.target);
      this.camera.position.x += away * Math.sin(turn);
      this.camera.position.z += away * Math.cos(turn);
      this.controls.update();
      this.draw();
    },
    turntable(on) {
      this.turning = on;
      if (this.controls) this.controls.autoRotate = on;
      this.draw();
    },
    // What skin or hair wears, or clay and plain hair where there is no address.
    async texture(name, url) {
      if (!this.renderer) return;
      const material = this.materials[name];
      material.wanted = url; // a picture that comes later than a newer wish is left
      const map = url ? await new THREE.TextureLoader().loadAsync(url) : null;
      if (material.wanted !== url) return map?.dispose();
      if (map) map.colorSpace = THREE.SRGBColorSpace;
      material.map?.dispose();
      material.map = map;
      material.vertexColors = name === "hair" && !map;
      if (name === "skin") material.color.set(map ? 0xffffff : CLAY);
      material.needsUpdate = true;
      this.draw();
    },
    key(event) {
      const turn = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (!turn || !this.renderer) return;
      event.preventDefault();
      const offset = this.camera.position.clone().sub(this.controls.target);
      const place = new THREE.Spherical().setFromVector3(offset);
      place.theta += turn[0];
      place.phi = Math.min(Math.PI - 0.1, Math.max(0.1, place.phi + turn[1]));
      this.camera.position.setFromSpherical(place).add(this.controls.target);
      this.controls.update();
      this.draw();
    },
    // Dragging a point of the surface: the server says once how all others follow, and the page moves them.
    pulling(on) {
      this.canPull = on;
      this.canvas.style.cursor = on ? "crosshair" : "";
    },
    ray(event) {
      const box = this.canvas.getBoundingClientRect();
      const x = (2 * (event.clientX - box.left)) / box.width - 1;
      const y = 1 - (2 * (event.clientY - box.top)) / box.height;
      const caster = new THREE.Raycaster();
      caster.setFromCamera(new THREE.Vector2(x, y), this.camera);
      return caster;
    },
    grab(event) {
      if (!this.canPull || event.button || !this.positions || this.pulled) return;
      const hit = this.ray(event).intersectObject(this.head).find((each) => each.faceIndex < this.skin);
      if (!hit) return;
      let nearest = -1;
      let least = Infinity;
      for (const corner of [hit.face.a, hit.face.b, hit.face.c]) {
        const from = 3 * this.owners[corner];
        const gap = hit.point.distanceTo(new THREE.Vector3().fromArray(this.positions, from));
        if (gap < least) [least, nearest] = [gap, this.owners[corner]];
      }
      const start = new THREE.Vector3().fromArray(this.positions, 3 * nearest);
      const plane = new THREE.Plane();
      plane.setFromNormalAndCoplanarPoint(this.camera.getWorldDirection(new THREE.Vector3()), hit.point);
      const by = new THREE.Vector3();
      this.pulled = { id: event.pointerId, vertex: nearest, start, from: hit.point.clone(), plane, by, rest: this.positions };
      this.controls.enabled = false;
      this.canvas.setPointerCapture(event.pointerId);
      this.dot.position.copy(start);
      this.dot.visible = true;
      this.$emit("grab", { vertex: nearest });
      this.draw();
    },
    async basis(number, vertex) {
      const answer = await fetch(`${this.base}/basis/${number}`);
      if (!answer.ok || this.pulled?.vertex !== vertex) return;
      this.pulled.ways = new Float32Array(await answer.arrayBuffer());
      this.follow();
    },
    drag(event) {
      const pulled = this.pulled;
      if (pulled?.id !== event.pointerId) return;
      const point = this.ray(event).ray.intersectPlane(pulled.plane, new THREE.Vector3());
      if (!point) return;
      pulled.by.copy(point).sub(pulled.from);
      this.dot.position.copy(pulled.start).add(pulled.by);
      this.follow();
      this.draw();
    },
    follow() {
      const { ways, by, rest } = this.pulled;
      if (!ways) return;
      const moved = new Float32Array(rest);
      const count = moved.length;
      for (let k = 0; k < count; k++)
        moved[k] += by.x * ways[k] + by.y * ways[count + k] + by.z * ways[2 * count + k];
      this.place(moved);
      this.canvas.dataset.pulled = Number(this.canvas.dataset.pulled ?? 0) + 1;
      this.draw();
    },
    release(event) {
      if (this.pulled?.id !== event.pointerId) return;
      const { vertex, by } = this.pulled;
      this.pulled = null;
      this.controls.enabled = true;
      this.$emit("pull", { vertex, by: by.toArray() });
    },
    // Strokes on the head. Without perspective, so that a place of the picture is a place of the face at any depth.
    drawing(tool, radius) {
      this.tool = tool;
      this.radius = radius;
      this.canvas.style.cursor = tool ? "crosshair" : "";
      if (!this.renderer) return;
      this.flat = tool ? (this.flat ?? new THREE.OrthographicCamera()) : null;
      this.chosen.forEach((dots) => (dots.visible = Boolean(tool)));
      if (this.flat) this.flatten();
      this.draw();
    },
    eye() {
      if (this.flat) this.flatten();
      return this.flat ?? this.camera;
    },
    // The view without perspective in which the middle of the head is as large as with it.
    flatten() {
      const away = this.camera.position.distanceTo(this.controls.target);
      const half = away * Math.tan((this.camera.fov * Math.PI) / 360);
      const aside = half * this.camera.aspect;
      Object.assign(this.flat, { left: -aside, right: aside, top: half, bottom: -half, near: 0.01, far: 10 });
      this.flat.position.copy(this.camera.position);
      this.flat.quaternion.copy(this.camera.quaternion);
      this.flat.updateProjectionMatrix();
      this.flat.updateMatrixWorld();
    },
    // As the server's camera: pixels per metre, the way from the face's axes to x right, y down, z into the picture.
    seen() {
      const box = this.canvas.getBoundingClientRect();
      const scale = box.height / (this.flat.top - this.flat.bottom);
      const turn = new THREE.Matrix4().makeRotationFromQuaternion(this.flat.quaternion).elements;
      const rotation = [0, 1, 2].map((row) => [0, 1, 2].map((k) => (row ? -1 : 1) * turn[4 * row + k]));
      const place = this.flat.position.toArray();
      const shift = (row) => -scale * rotation[row].reduce((sum, each, k) => sum + each * place[k], 0);
      return { scale, rotation, translation: [box.width / 2 + shift(0), box.height / 2 + shift(1)] };
    },
    spot(event) {
      const box = this.canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    },
    pen(event) {
      if (!this.tool || event.button || !this.positions || this.stroke) return;
      event.preventDefault();
      this.controls.enabled = false;
      this.canvas.setPointerCapture(event.pointerId);
      this.stroke = [this.spot(event)];
      this.hand = event.pointerId;
      this.ink(event);
    },
    ink(event) {
      if (!this.stroke || this.hand !== event.pointerId) return;
      for (const each of event.getCoalescedEvents?.().length ? event.getCoalescedEvents() : [event]) {
        const point = this.spot(each);
        const last = this.stroke.at(-1);
        if (Math.hypot(point[0] - last[0], point[1] - last[1]) >= 1) this.stroke.push(point);
      }
      this.trace(this.stroke);
    },
    trace(points) {
      const line = this.$el.querySelector(".caricli-ink polyline");
      const brush = this.tool === "brush" || this.tool === "rub";
      line.setAttribute("points", points.join(" "));
      line.setAttribute("stroke-width", brush ? 2 * this.radius : 3);
      line.setAttribute("stroke-opacity", brush ? 0.45 : 1);
    },
    lift(event) {
      if (!this.stroke || this.hand !== event.pointerId) return;
      const points = this.stroke.map((point) => point.map((each) => Math.round(100 * each) / 100));
      this.stroke = null;
      this.controls.enabled = true;
      this.trace([]);
      if (points.length > 1 || this.tool === "brush" || this.tool === "rub")
        this.$emit("stroke", { tool: this.tool, points, camera: this.seen() });
    },
    // What the browser takes for a palm, or for a gesture of its own, did nothing.
    cancel(event) {
      if (this.pulled?.id === event.pointerId) {
        this.place(this.positions);
        this.dot.visible = false;
        this.pulled = null;
      } else if (this.stroke && this.hand === event.pointerId) {
        this.stroke = null;
        this.trace([]);
      } else return;
      this.controls.enabled = true;
      this.draw();
    },
    // The vertices that are chosen: of the region, and handles.
    dots(color) {
      const material = new THREE.PointsMaterial({ color, size: 3, sizeAttenuation: false });
      const dots = new THREE.Points(new THREE.BufferGeometry(), material);
      dots.frustumCulled = false;
      dots.visible = false;
      dots.ids = [];
      this.scene.add(dots);
      return dots;
    },
    select(handles, region) {
      if (!this.renderer) return;
      this.chosen[0].ids = region;
      this.chosen[1].ids = handles;
      this.mark();
      this.draw();
    },
    mark() {
      if (!this.positions) return;
      for (const dots of this.chosen) {
        const places = new Float32Array(3 * dots.ids.length);
        dots.ids.forEach((id, k) => {
          // A little before the skin, so that it is not half sunk in.
          for (let axis = 0; axis < 3; axis++)
            places[3 * k + axis] = this.positions[3 * id + axis] + 0.0006 * this.normals[3 * id + axis];
        });
        dots.geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
      }
    },
    picture() {
      this.renderer.render(this.scene, this.camera);
      return this.canvas.toDataURL("image/png");
    },
    // Of all vertices, metres.
    coordinates() {
      return Array.from(this.positions ?? []);
    },
  },
};
