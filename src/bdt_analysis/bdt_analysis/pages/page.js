// Every page: light or dark, and tables that go to a spreadsheet.
"use strict";

// The choice of the visitor wins over that of the system; where nothing can be stored it lasts
// as long as the page.
function storedTheme(value) {
  try {
    if (value !== undefined) localStorage.setItem("bdt-theme", value);
    return localStorage.getItem("bdt-theme");
  } catch (refused) {
    return value;
  }
}

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function useTheme(name) {
  if (name) document.documentElement.dataset.theme = name;
  document.getElementById("theme").textContent = isDark() ? "Light" : "Dark";
  document.dispatchEvent(new Event("theme"));
}

// Header with the units, then the rows as they are shown; blank cells stay blank.
function tabSeparated(table) {
  const cell = (item) => item.textContent.replace(/\s+/g, " ").trim();
  return [...table.rows].map((row) => [...row.cells].map(cell).join("\t")).join("\n") + "\n";
}

// The clipboard's own interface is refused to some pages that are opened from disk.
async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch (refused) {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

function offerCopies() {
  for (const table of document.querySelectorAll("table[id]")) {
    const button = document.querySelector(`button[data-copies="${table.id}"]`);
    if (!button) continue;
    button.hidden = false;
    button.addEventListener("click", async () => {
      const done = await copyText(tabSeparated(table));
      const label = button.textContent;
      button.textContent = done ? "Copied" : "Refused by the browser";
      setTimeout(() => { button.textContent = label; }, 1500);
    });
  }
}

document.getElementById("theme").hidden = false;
document.getElementById("theme").addEventListener("click", () => {
  useTheme(storedTheme(isDark() ? "light" : "dark"));
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => useTheme(null));
useTheme(storedTheme());
offerCopies();
