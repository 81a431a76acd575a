"use strict";
// The recent readings of the chosen robot: one dot per reading, in the colour that its sensor said.

class Trail {
  constructor(stage) {
    this.stage = stage;
    const dots = (wanted, times, attributes) => stage.path(stage.swarm, (g) => circles(g, this.places(wanted), times * this.size), { visible: false, ...attributes });
    this.parts = [
      (this.rim = dots(() => true, 1.8)),
      dots(({ said }) => !said, 1, { fill: "#ffffff" }),
      dots(({ said }) => said, 1, { fill: "#101010" }),
      dots(({ wrong }) => wrong, 1.7, { stroke: "#ffffff", strokeWidth: 2.5 }),
      dots(({ wrong }) => wrong, 1.7, { stroke: "#000000", strokeWidth: 1.2, dash: [3, 2.5] }),
    ];
  }

  show(visible) {
    const { scene, pixel } = this.stage;
    for (const part of this.parts) part.visible(visible);
    this.rim.fill(tone("--trail"));
    if (!visible) return;
    this.size = Math.min(Math.max(scene.tile / scene.side / 2, 1.5 * pixel), 5 * pixel);
    for (const ring of this.parts.slice(3)) ring.visible(this.size > 2 * pixel); // smaller rings would overlap
  }

  // where its sensor was at the readings that `wanted` selects
  places(wanted) {
    const { scene, before, chosen } = this.stage;
    const [ahead, left] = scene.sensor.map((metres) => metres / scene.side);
    const found = [];
    for (const frame of before) {
      const look = lookOf(frame, chosen);
      if (!look || !wanted(look)) continue;
      const angle = (frame.headings[chosen] / 256) * 2 * Math.PI;
      const [x, y] = this.stage.place(chosen, frame);
      found.push([x + ahead * Math.cos(angle) - left * Math.sin(angle), y - ahead * Math.sin(angle) - left * Math.cos(angle)]);
    }
    return found;
  }
}
