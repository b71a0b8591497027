// The socket to the server: messages in, requests out, and again when it breaks.

const SOONEST = 500;
const LATEST = 5000; // ms between two tries

export class Connection {
  // `take` gets every message; `tell` whether there is a connection, and whether there is a
  // server that does not know this page, as after its restart.
  constructor(take, tell) {
    this.take = take;
    this.tell = tell;
    this.number = 0;
    this.answers = new Map();
    this.wait = SOONEST;
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.socket.addEventListener("open", () => {
      this.wait = SOONEST;
      this.tell({ isThere: true, isStranger: false });
    });
    this.socket.addEventListener("message", (event) => this.receive(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => {
      for (const answer of this.answers.values()) answer("the connection is lost");
      this.answers.clear();
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LATEST);
      this.ponder();
    });
  }

  // Tell why there is no connection: nobody answers, or a server that refuses.
  async ponder() {
    this.tell({ isThere: false, isStranger: false });
    const answer = await fetch("/", { cache: "no-store" }).catch(() => null);
    if (answer?.status === 403) this.tell({ isThere: false, isStranger: true });
  }

  receive(message) {
    if (message.type === "reply") {
      this.answers.get(message.number)?.(message.reason);
      this.answers.delete(message.number);
    } else {
      this.take(message);
    }
  }

  // Ask for something; the promise gives the reason why not, or null.
  ask(action, fields = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.resolve("there is no connection");
    this.number += 1;
    const { number } = this;
    this.socket.send(JSON.stringify({ number, action, ...fields }));
    return new Promise((resolve) => { this.answers.set(number, resolve); });
  }
}
