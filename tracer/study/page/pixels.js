"use strict";
// Pictures and maps as numbers: read the codes of the page's images, and turn them into colours for a screen.

const study = JSON.parse(document.getElementById("study").textContent);
const colourTable = Uint8Array.from(study.colours.match(/../g), (pair) => parseInt(pair, 16));

/** Return width, height and codes of an image in the page, `channels` per pixel. */
async function readCodes(name, channels) {
  const image = document.getElementById(name);
  await image.decode();
  const width = image.naturalWidth, height = image.naturalHeight;
  const context = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  const pixels = context.getImageData(0, 0, width, height).data, codes = new Uint8Array(channels * width * height);
  for (let k = 0; k < width * height; k++)
    for (let channel = 0; channel < channels; channel++) codes[channels * k + channel] = pixels[4 * k + channel];
  return { width, height, codes };
}

/** Return a picture with its linear values, three per pixel. */
async function readPicture(name) {
  const { width, height, codes } = await readCodes(name, 3);
  return { width, height, values: Float32Array.from(codes, (code) => study.values[code]) };
}

/** Return the map of relative errors. */
async function readErrors(name, top) {
  const { width, height, codes } = await readCodes(name, 1);
  return { width, height, values: Float32Array.from(codes, (code) => study.headroom * top * (code / 255) ** 2) };
}

/** Return the map of samples per pixel; `counts` is the name of an image, or a number that holds for all pixels. */
async function readCounts(counts, [least, most]) {
  if (typeof counts === "number") return { width: 1, height: 1, values: Float32Array.of(counts) };
  const { width, height, codes } = await readCodes(counts, 1), from = Math.max(least, 1);
  return { width, height, values: Float32Array.from(codes, (code) => from * (Math.max(most, 1) / from) ** (code / 255)) };
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
