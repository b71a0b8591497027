// One parameter of a node as a control of the page.

const DEGREE = Math.PI / 180;
const ECHO = 200; // ms in which a node still tells of values that were asked for before the last one

// Parameters that come first, and what they are called here.
export const RATHER = [
  ["controller", "reference.first", "reference, high"],
  ["controller", "reference.second", "reference, low"],
  ["plant", "gap.initial", "gap"],
  ["twin", "reconfigure", "twin sets the dead zone"],
  ["controller", "dead_zone_tolerance", "dead zone ±"],
  ["controller", "pid.proportional", "gain, proportional"],
  ["controller", "pid.integral", "gain, integral"],
  ["controller", "pid.derivative", "gain, derivative"],
  ["plant", "sensor.noise", "noise of the sensor"],
  ["plant", "motor.coulomb_friction", "friction"],
  ["twin", "communication_delay", "delay of the link"],
];

// Units that people think in: what a unit is shown as, and how much of it one is.
const SHOWN = { rad: ["°", DEGREE], "N m": ["mN m", 1e-3] };
const SMALL = ["µm", 1e-6];
const MIDDLE = ["mm", 1e-3];

function unitOf({ unit, high }) {
  if (unit === "m" && high !== undefined) return Math.abs(high) <= 1e-3 ? SMALL : MIDDLE;
  return SHOWN[unit] ?? [unit, 1];
}

export class Control {
  // `set` asks the node for a value and promises its reason, or null; `shortest` is the time [ms]
  // between two values of a slider that is dragged.
  constructor(node, described, set, shortest) {
    this.described = described;
    this.setValue = set;
    this.shortest = shortest;
    [this.unit, this.scale] = unitOf(described);
    this.id = `${node}.${described.name}`;
    this.element = document.createElement("div");
    this.element.className = "control";
    this.element.title = `${node} ${described.name}: ${described.text}${described.allowed ? ` (${described.allowed})` : ""}`;
    const label = document.createElement("label");
    label.htmlFor = this.id;
    const called = RATHER.find(([owner, name]) => owner === node && name === described.name)?.[2];
    label.append(called ?? described.name);
    if (this.unit) {
      const unit = document.createElement("span");
      unit.className = "unit";
      unit.textContent = ` [${this.unit}]`;
      label.append(unit);
    }
    this.reason = document.createElement("p");
    this.reason.className = "reason";
    this.reason.setAttribute("role", "alert");
    this.reason.hidden = true;
    this.element.append(label, ...this.inputs(), this.reason);
    this.show(described.value);
  }

  inputs() {
    const { kind } = this.described;
    if (kind === "choice") {
      this.field = document.createElement("select");
      for (const choice of this.described.choices) this.field.add(new Option(choice, choice));
    } else {
      this.field = document.createElement("input");
      this.field.type = { switch: "checkbox", slider: "number" }[kind] ?? "text";
      if (kind === "slider") this.field.step = "any";
    }
    this.field.id = this.id;
    this.field.addEventListener("change", () => this.ask(this.typed()));
    if (kind !== "slider") return [this.field];
    this.slider = document.createElement("input");
    this.slider.type = "range";
    this.slider.setAttribute("aria-label", `${this.id}, slider`);
    this.slider.min = this.described.low;
    this.slider.max = this.described.high;
    this.slider.step = this.described.step;
    this.slider.addEventListener("input", () => this.drag());
    this.slider.addEventListener("change", () => this.ask(Number(this.slider.value)));
    return [this.field, this.slider];
  }

  typed() {
    const { kind } = this.described;
    if (kind === "switch") return this.field.checked;
    return kind === "slider" ? Number(this.field.value) * this.scale : this.field.value;
  }

  // Ask while the slider is dragged, as often as is of use.
  drag() {
    this.field.value = this.worded(Number(this.slider.value));
    if (this.waiting) return;
    const value = Number(this.slider.value);
    this.ask(value);
    this.waiting = setTimeout(() => {
      this.waiting = null;
      if (Number(this.slider.value) !== value) this.drag();
    }, this.shortest);
  }

  async ask(value) {
    this.asked = (this.asked ?? 0) + 1;
    const turn = this.asked;
    clearTimeout(this.settling);
    this.isAsking = true;
    const reason = await this.setValue(value);
    if (turn !== this.asked) return; // another value has been asked for meanwhile
    this.reason.textContent = reason ?? "";
    this.reason.hidden = !reason;
    const settle = () => {
      this.isAsking = false;
      this.show(this.value);
    };
    if (reason) settle();
    else this.settling = setTimeout(settle, ECHO);
  }

  // Show the value in force, whoever has set it.
  show(value) {
    const isNews = this.value !== undefined && this.value !== value && document.activeElement !== this.slider;
    this.value = value;
    if (this.described.kind === "switch") {
      this.field.checked = value;
    } else if (this.described.kind === "slider") {
      // What comes meanwhile is mostly what was dragged over.
      if (!this.isAsking && !this.slider.matches(":active")) {
        if (value < Number(this.slider.min)) this.slider.min = value;
        if (value > Number(this.slider.max)) this.slider.max = value;
        this.slider.value = value;
        this.field.value = this.worded(value);
      }
    } else {
      this.field.value = value;
    }
    if (isNews) {
      this.element.classList.add("news");
      clearTimeout(this.fading);
      this.fading = setTimeout(() => this.element.classList.remove("news"), 1500);
    }
  }

  // Show a value that is not the parameter's, unless somebody is about to set it.
  follow(value) {
    if (this.element.contains(document.activeElement) || this.slider.matches(":active")) return;
    this.slider.value = value;
    this.field.value = this.worded(value);
  }

  worded(value) {
    return String(Number((value / this.scale).toPrecision(5)));
  }
}
