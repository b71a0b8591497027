// Colors of the style sheet for what is drawn on canvases.

const NAMES = [
  "blue", "orange", "red", "green", "purple", "yellow", "background", "panel", "edge", "text", "quiet",
  "metal", "metal-light", "beam",
];

export const palette = {};

export function readPalette() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) palette[name] = style.getPropertyValue(`--${name}`).trim();
}

// A color with some transparency, 0 to 1.
export function faded(color, share) {
  return `color-mix(in srgb, ${color} ${Math.round(100 * share)}%, transparent)`;
}
