// The loop's state in a word, its nodes, and their log lines.

const MOST_LINES = 60;

export class Nodes {
  constructor(state, reason, list, log) {
    this.state = state;
    this.reason = reason;
    this.list = list;
    this.log = log;
  }

  take({ word, cause, reason, nodes }) {
    this.tell(word, cause ? `${word}: ${cause}` : word, reason);
    // A wall has no mouse to point at the state with.
    this.reason.textContent = word === "ok" && nodes.length ? "" : reason;
    this.list.replaceChildren(...nodes.map((node) => {
      const item = document.createElement("li");
      item.dataset.level = node.level;
      const name = document.createElement("span");
      name.textContent = node.name;
      const words = document.createElement("span");
      words.className = "text";
      words.textContent = node.level === 3 ? `silent for ${node.age.toFixed(0)} s` : node.text;
      item.append(name, words);
      return item;
    }));
  }

  tell(word, text, reason = "") {
    if (this.state.textContent === text && this.state.title === reason) return;
    this.state.dataset.word = word;
    this.state.textContent = text;
    this.state.title = reason;
  }

  // Add a line; `link` is an address that it leads to.
  addLine(text, level = 20, link = null) {
    const item = document.createElement("li");
    item.dataset.level = level;
    if (link) {
      const anchor = document.createElement("a");
      anchor.href = link;
      anchor.target = "_blank";
      anchor.rel = "noopener";
      anchor.textContent = text;
      item.append(anchor);
    } else {
      item.textContent = text;
    }
    this.log.prepend(item);
    while (this.log.childElementCount > MOST_LINES) this.log.lastElementChild.remove();
  }
}
