// Colours between linear light, which scenes hold, and sRGB, which screens show.

/** sRGB of a channel of linear light, both in [0, 1]. */
export function encoded(linear) {
  const x = Math.min(Math.max(linear, 0), 1);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
}

/** Linear light of a channel of sRGB. */
export function decoded(shown) {
  return shown <= 0.04045 ? shown / 12.92 : ((shown + 0.055) / 1.055) ** 2.4;
}

/** `#rrggbb` of a linear colour. */
export function hex(linear) {
  const byte = (c) => Math.round(255 * encoded(c)).toString(16).padStart(2, "0");
  return `#${linear.map(byte).join("")}`;
}

/** Linear colour of `#rrggbb`. */
export function linear(text) {
  return [1, 3, 5].map((i) => decoded(parseInt(text.slice(i, i + 2), 16) / 255));
}

/** A number as people read it, of three digits or so. */
export function short(x) {
  if (!Number.isFinite(x)) return "–";
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return x.toExponential(1).replace("e+", "e");
  return String(Number(x.toPrecision(size >= 1000 ? 4 : 3)));
}
