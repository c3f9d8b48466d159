"use strict";
// Pictures as numbers: decode them, and turn them into colours for a screen.

const study = JSON.parse(document.getElementById("study").textContent);

const halfTable = (() => {
  const table = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const exponent = (bits >> 10) & 31, fraction = bits & 1023;
    const size = exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15);
    table[bits] = bits & 0x8000 ? -size : size;
  }
  return table;
})();

const colourTable = Uint8Array.from(study.colours.match(/../g), (pair) => parseInt(pair, 16));

/** Return the 16-bit words (channels x height x width) of a block that encode.py made. */
async function decodeWords(name, channels, width, height) {
  const bytes = Uint8Array.from(atob(document.getElementById(name).textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const count = channels * width * height, words = new Uint16Array(count);
  for (let k = 0; k < count; k++) {
    const difference = planes[k] | (planes[count + k] << 8);
    words[k] = k % width === 0 ? difference : words[k - 1] + difference;
  }
  return words;
}

/** Return the linear values of a picture, three per pixel. */
async function decodePicture(name, width, height) {
  const words = await decodeWords(name, 3, width, height), pixels = width * height;
  const values = new Float32Array(3 * pixels);
  for (let channel = 0; channel < 3; channel++)
    for (let k = 0; k < pixels; k++) values[3 * k + channel] = halfTable[words[channel * pixels + k]];
  return values;
}

/** Return the samples of every pixel; `counts` is the name of a block, or a number that holds for all pixels. */
async function decodeCounts(counts, width, height) {
  return typeof counts === "number" ? new Float32Array(width * height).fill(counts) : decodeWords(counts, 1, width, height);
}

function luminance(values, k) {
  return 0.212671 * values[3 * k] + 0.71516 * values[3 * k + 1] + 0.072169 * values[3 * k + 2];
}

/** Return the relative error of every pixel: root mean square over channels, over the reference's luminance. */
function relativeError(values, reference) {
  return Float32Array.from({ length: values.length / 3 }, (_, k) => {
    let sum = 0;
    for (let channel = 0; channel < 3; channel++) sum += (values[3 * k + channel] - reference[3 * k + channel]) ** 2;
    return Math.sqrt(sum / 3 / (luminance(reference, k) ** 2 + 0.01));
  });
}

/** Paint linear values with the sRGB curve after `stops` of exposure. */
function paintPicture(pixels, values, stops) {
  const gain = 2 ** stops;
  for (let k = 0, pixel = 0; k < values.length; k += 3, pixel += 4) {
    for (let channel = 0; channel < 3; channel++) {
      const x = values[k + channel] * gain;
      pixels[pixel + channel] = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055); // the array rounds
    }
    pixels[pixel + 3] = 255;
  }
}

/** Paint values in the colours of the table; `scale` maps them to 0 .. 1. */
function paintValues(pixels, values, scale) {
  for (let k = 0; k < values.length; k++) {
    const entry = 3 * Math.round(255 * Math.min(1, Math.max(0, scale(values[k]))));
    for (let channel = 0; channel < 3; channel++) pixels[4 * k + channel] = colourTable[entry + channel];
    pixels[4 * k + 3] = 255;
  }
}
