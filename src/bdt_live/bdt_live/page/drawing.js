// What all canvases are drawn with.

// A canvas' context for drawing in CSS pixels, with its size; null while it has none.
export function drawingOf(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (!width || !height) return null;
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

export function text(context, words, x, y, color, align = "left") {
  context.fillStyle = color;
  context.textAlign = align;
  context.fillText(words, x, y);
}

export function arrow(context, x, y, length, color) {
  if (Math.abs(length) < 3) return;
  const head = Math.sign(length) * Math.min(8, Math.abs(length));
  context.strokeStyle = color;
  context.fillStyle = color;
  context.lineWidth = 3;
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + length - head, y);
  context.stroke();
  context.beginPath();
  context.moveTo(x + length, y);
  context.lineTo(x + length - head, y - 5);
  context.lineTo(x + length - head, y + 5);
  context.fill();
}
