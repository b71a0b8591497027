// Sliders, switches and fields, made from what the nodes say of their parameters.

import { RATHER, Control } from "./control.js";

const SHORTEST = 40; // ms between two values of a slider that is dragged
const NOTHING = "nothing can be set: no node answers";
const OF_BUTTONS = ["plant.pace", "plant.pause_at"]; // what is set at the top of the page

export class Controls {
  constructor(place, connection) {
    this.place = place;
    this.connection = connection;
    this.nodes = new Map(); // by node: by name: the control
    this.notes = []; // called with (node, name, value) for each value in force
    this.grows = false; // whether the gap is another one than its parameter says
  }

  // Take all controls of a node; none of a node that is not there.
  take({ node, controls }) {
    const made = new Map();
    for (const described of controls) {
      this.note(node, described.name, described.value);
      if (described.kind === "fixed" || OF_BUTTONS.includes(`${node}.${described.name}`)) continue;
      const set = (value) => this.set(node, described.name, value);
      made.set(described.name, new Control(node, described, set, SHORTEST));
    }
    this.nodes.set(node, made);
    this.lay();
  }

  // Tell whether there is something to set of a node.
  offers(node) { return Boolean(this.nodes.get(node)?.size); }

  takeValues({ node, values }) {
    for (const [name, value] of Object.entries(values)) {
      this.nodes.get(node)?.get(name)?.show(value);
      this.note(node, name, value);
    }
  }

  note(node, name, value) {
    if (node === "plant" && name === "gap.kind") this.grows = value !== "constant";
    for (const take of this.notes) take(node, name, value);
  }

  async set(node, name, value) {
    // Whoever drags the gap wants that one, and no growth.
    const values = name === "gap.initial" ? { "gap.kind": "constant", [name]: value } : { [name]: value };
    // Taken over, a dead zone stays: the twin sets it again only when it is given back.
    if (name === "dead_zone_tolerance" && this.nodes.get("twin")?.get("reconfigure")?.value === true) {
      const reason = await this.connection.ask("set", { node: "twin", values: { reconfigure: false } });
      if (reason) return reason;
    }
    return this.connection.ask("set", { node, values });
  }

  // Show where a gap [rad] is that grows.
  follow(gap) {
    if (this.grows && Number.isFinite(gap)) this.nodes.get("plant")?.get("gap.initial")?.follow(gap);
  }

  lay() {
    const open = new Set([...this.place.querySelectorAll("details[open]")].map((each) => each.dataset.node));
    const focused = document.activeElement?.id;
    const rather = RATHER.map(([node, name]) => this.nodes.get(node)?.get(name)).filter(Boolean);
    const groups = [...this.nodes].filter(([, controls]) => controls.size).map(([node, controls]) => {
      const rest = [...controls.values()].filter((control) => !rather.includes(control));
      const group = document.createElement("details");
      group.dataset.node = node;
      group.open = open.has(node);
      const summary = document.createElement("summary");
      summary.textContent = `more of the ${node}`;
      group.append(summary, ...rest.map((control) => control.element));
      return rest.length ? group : "";
    });
    this.place.replaceChildren(...rather.map((control) => control.element), ...groups);
    if (focused) document.getElementById(focused)?.focus();
    if (!this.place.childElementCount) {
      const words = document.createElement("p");
      words.className = "quiet";
      words.textContent = NOTHING;
      this.place.append(words);
    }
  }
}
