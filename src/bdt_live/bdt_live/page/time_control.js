// Pause, step, pace, mark, save, presets and wear: buttons and keys that ask the loop.

const KEYS = { " ": "pause", ".": "step", m: "mark", s: "save", d: "theme" };
const PRESET_KEYS = { 3: "linear", 4: "fixed_dead_zone", 7: "paper" }; // the paper's figures

export class TimeControl {
  constructor(connection, nodes) {
    this.connection = connection;
    this.nodes = nodes;
    this.paused = false;
    this.button("pause").addEventListener("click", () => this.ask(this.paused ? "resume" : "pause"));
    for (const action of ["step", "mark", "save", "wear"]) {
      this.button(action).addEventListener("click", () => this.ask(action));
    }
    this.pace = this.button("pace");
    this.pace.addEventListener("change", () => this.ask("pace", { amount: Number(this.pace.value) }));
    for (const button of document.querySelectorAll("[data-preset]")) {
      button.addEventListener("click", () => this.ask("preset", { preset: button.dataset.preset }));
    }
    this.allow(false);
    document.addEventListener("keydown", (event) => this.press(event));
  }

  // Presets and wear are for a loop that can be asked, which a bag cannot.
  allow(isAllowed) {
    for (const button of document.querySelectorAll("[data-preset], #wear")) button.disabled = !isAllowed;
  }

  button(name) { return document.getElementById(name); }

  press(event) {
    if (takesKey(event.target, event.key) || event.ctrlKey || event.altKey || event.metaKey) return;
    const button = event.key in PRESET_KEYS
      ? document.querySelector(`[data-preset="${PRESET_KEYS[event.key]}"]`)
      : this.button(KEYS[event.key]);
    if (!button) return;
    event.preventDefault();
    button.click();
  }

  async ask(action, fields) {
    const reason = await this.connection.ask(action, fields);
    if (reason) this.nodes.addLine(`${action}: ${reason}`, 40);
  }

  take({ pace, paused, over = false }) {
    this.paused = paused;
    const button = this.button("pause");
    // A bag that is over goes on from its beginning.
    const on = over ? "Again" : "Go on";
    button.textContent = paused ? on : "Pause";
    button.setAttribute("aria-pressed", paused);
    const can = pace !== null;
    for (const each of [button, this.button("step"), this.pace]) each.disabled = !can;
    this.button("step").disabled = !can || !paused;
    if (can && document.activeElement !== this.pace) this.showPace(pace);
  }

  // Show a pace; one that is none of the page's own has an entry for as long as it lasts.
  showPace(pace) {
    const value = String(pace);
    const before = this.pace.querySelector(".other");
    if (before && before.value !== value) before.remove();
    if (![...this.pace.options].some((each) => each.value === value)) {
      const other = new Option(pace ? `${pace}×` : "full speed", value);
      other.className = "other";
      this.pace.add(other);
    }
    this.pace.value = value;
  }
}

// Whether an element does something else with a key: it is typed there, or presses a button.
function takesKey(element, key) {
  if (element.closest("select, input[type=number], input[type=text]")) return true;
  return key === " " && Boolean(element.closest("input, button, summary, a"));
}
