// How many harmonics the sample bodies of the music room have, baked or solved for in the page.

/** Those of the plate are seen first; sand needs no more. */
export const sampleHarmonics = (name) => (name === "plate" ? 64 : 96);
