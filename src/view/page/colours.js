// Colours for numbers. Groups: well apart also for eyes that see red and green alike (Okabe and Ito 2008).
const GROUPS = [[.34, .71, .91], [.9, .62, 0], [0, .62, .45], [.94, .89, .26], [0, .45, .7], [.84, .37, 0], [.8, .47, .65], [.6, .6, .6]];
export const PLAIN = [.55, .68, .82], INSIDE = [.93, .78, .5];

export const group_colour = n => GROUPS[((n % GROUPS.length) + GROUPS.length) % GROUPS.length];

// One layer is pale, more are deeper.
export const layer_colour = n => n <= 1 ? [.75, .8, .85] : n === 2 ? [.9, .55, .1] : n === 3 ? [.75, .15, .2] : [.4, 0, .4];

// Angles: red at 0 degrees, yellow at 20, blue from 40 on.
export function angle_colour(degrees) {
  const x = Math.max(0, Math.min(1, degrees / 40));
  return x < .5 ? [.8 + .2 * x, .1 + 1.6 * x, .1] : [1.8 - 1.8 * x, 1.3 - .8 * x, .1 + 1.4 * (x - .5)];
}
export const css = c => `rgb(${c.map(x => Math.round(255 * x)).join(" ")})`;
