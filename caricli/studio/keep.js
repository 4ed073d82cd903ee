// Keeps what was done in this browser, so that nothing is lost when the server ends; opens files; listens to keys.
const PREFIX = "caricli-studio-";
const AT = "caricli-at-"; // before the name: when it was kept, milliseconds
const MOST = 32; // drawings of tabs that are kept, as many as a server has desks
const NOTHING = '"operations":[]}'; // ends what is kept of a tab where nothing was done

function tab() {
  let name = sessionStorage.getItem("caricli-tab");
  if (!name) {
    name = `${Date.now()}-${Math.random().toString(36).slice(2)}`;
    sessionStorage.setItem("caricli-tab", name);
  }
  return PREFIX + name;
}

export default {
  template: `
    <div class="caricli-keep">
      <input ref="file" type="file" hidden tabindex="-1" aria-label="File to open" @change="chosen" />
      <div role="alert" class="caricli-lost" v-show="lost">{{ lost }}</div>
    </div>`,
  props: { base: String, begun: Object },
  data() {
    return { lost: "" };
  },
  mounted() {
    // A tab that was duplicated has the name of the other: whoever comes second takes a new one.
    this.name = tab();
    this.channel = new BroadcastChannel("caricli-studio");
    this.channel.onmessage = ({ data }) => {
      if (data.ask === this.name) this.channel.postMessage({ taken: this.name });
      if (data.taken === this.name && this.asking) {
        sessionStorage.removeItem("caricli-tab");
        this.name = tab();
        this.asking = false;
      }
    };
    this.asking = true;
    this.channel.postMessage({ ask: this.name });
    this.start = this.begun ?? null;
    this.operations = [];
    this.pending = [];
    window.caricliKeep = this;
    const listen = () => {
      if (!window.socket) return setTimeout(listen, 20);
      window.socket.on("disconnect", () => {
        this.lost = "The server does not answer. What you draw is kept in this browser and goes on when it is back.";
      });
      window.socket.on("connect", () => (this.lost = ""));
    };
    listen();
    window.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("dragover", (event) => event.preventDefault());
    window.addEventListener("drop", (event) => {
      event.preventDefault();
      if (event.dataTransfer.files[0]) this.send(event.dataTransfer.files[0]);
    });
    setTimeout(() => {
      this.asking = false;
      const kept = localStorage.getItem(this.name);
      // As a file: a message of the page may have a million letters alone.
      if (kept && !kept.endsWith(NOTHING)) this.send(new File([kept], "drawing.json"), "returned");
      else this.$emit("nothing");
    }, 120);
  },
  methods: {
    key(event) {
      const typing = /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName) && event.target.type !== "range";
      if (typing || !(event.ctrlKey || event.metaKey)) return;
      const name = { z: event.shiftKey ? "redo" : "undo", y: "redo", o: "open" }[event.key.toLowerCase()];
      if (!name) return;
      event.preventDefault();
      if (name === "open") this.choose();
      else this.$emit(name);
    },
    choose() {
      this.$refs.file.value = "";
      this.$refs.file.click();
    },
    chosen() {
      if (this.$refs.file.files[0]) this.send(this.$refs.file.files[0]);
    },
    // A file for the server, which answers nothing, or why it refuses it.
    async send(file, done = "opened") {
      try {
        const url = `${this.base}/open?name=${encodeURIComponent(file.name)}`;
        const answer = await fetch(url, { method: "POST", body: file });
        this.$emit(done, { refused: answer.ok ? "" : (await answer.text()).slice(0, 500) });
      } catch {
        this.$emit(done, { refused: `${file.name}: could not be sent to the server` });
      }
    },
    pend(operation) {
      this.pending.push(operation);
      this.write();
    },
    // The server has the first `count` operations; `more` came after those that are kept here.
    keep(start, count, more, answered) {
      this.start = start;
      this.operations.length = Math.min(count - more.length, this.operations.length);
      this.operations.push(...more);
      this.pending.splice(0, answered);
      this.write();
    },
    write() {
      const text = JSON.stringify({
        schema: "caricli.session/1",
        start: this.start,
        operations: [...this.operations, ...this.pending],
      });
      const at = (name) => Number(localStorage.getItem(AT + name));
      const others = Object.keys(localStorage).filter((name) => name.startsWith(PREFIX) && name !== this.name);
      others.sort((one, other) => at(one) - at(other));
      const drop = () => {
        const oldest = others.shift();
        localStorage.removeItem(oldest);
        localStorage.removeItem(AT + oldest);
      };
      while (others.length >= MOST) drop();
      let stored = this.stored(text);
      while (!stored && others.length) {
        drop();
        stored = this.stored(text);
      }
      if (!stored) this.lost = "This browser keeps no more: save the session before you go on.";
    },
    stored(text) {
      try {
        localStorage.setItem(AT + this.name, Date.now());
        localStorage.setItem(this.name, text);
        return true;
      } catch {
        return false;
      }
    },
  },
};
