// The signals that the page carries: unpacking them, and what of them a view shows.
"use strict";

// Text from drawing/embedding.py: base64 of gzip.
async function unpacked(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  const packed = Uint8Array.from(text, (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Inverse of packed_arrays: the bytes of equal weight stand together, the lowest first.
function floatArray(bytes, offset, count) {
  const mixed = new Uint8Array(4 * count);
  for (let weight = 0; weight < 4; weight += 1) {
    for (let k = 0; k < count; k += 1) mixed[4 * k + weight] = bytes[offset + weight * count + k];
  }
  return new Float32Array(mixed.buffer);
}

// Adds `time` [s] and `value` to each series of the description.
async function loadSignals(description) {
  const bytes = await unpacked("signals");
  let offset = 0;
  for (const series of description.series) {
    const relative = floatArray(bytes, offset, series.points);
    series.time = Float64Array.from(relative, (time) => time + description.origin);
    series.value = floatArray(bytes, offset + 4 * series.points, series.points);
    offset += 8 * series.points;
  }
}

// Index of the first time that is not before `time`.
function firstFrom(times, time) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time) low = middle + 1; else high = middle;
  }
  return low;
}

// What a view from `begin` to `end` draws: every point, or of each pixel column the first, the
// smallest, the largest and the last one. A NaN interrupts the line and stays.
function viewOf(series, begin, end, columns) {
  const first = Math.max(firstFrom(series.time, begin) - 1, 0);
  const last = Math.min(firstFrom(series.time, end) + 1, series.time.length);
  if (last - first <= 4 * columns) {
    return {
      x: series.time.slice(first, last), y: series.value.slice(first, last), whole: true,
    };
  }
  const x = [];
  const y = [];
  const column = (k) => Math.floor(((series.time[k] - begin) / (end - begin)) * columns);
  for (let start = first; start < last;) {
    const here = column(start);
    let smallest = start;
    let largest = start;
    let stop = start;
    let broken = false;
    for (; stop < last && column(stop) === here; stop += 1) {
      const value = series.value[stop];
      if (!Number.isFinite(value)) { broken = true; break; }
      if (value < series.value[smallest]) smallest = stop;
      if (value > series.value[largest]) largest = stop;
    }
    if (stop > start) {
      for (const k of [...new Set([start, smallest, largest, stop - 1])].sort((a, b) => a - b)) {
        x.push(series.time[k]);
        y.push(series.value[k]);
      }
    }
    if (broken) {
      x.push(series.time[stop]);
      y.push(NaN);
      stop += 1;
    }
    start = stop;
  }
  return { x, y, whole: false };
}
