"use strict";
// the visible part of the swarm, shared by both sides of a pair
class View {
  constructor() {
    this.zoom = 1;
    this.centre = [0.5, 0.5];
  }

  near(factor, at = this.centre) {
    const zoom = Math.min(Math.max(this.zoom * factor, 1), 40);
    const centre = this.centre.map((c, k) => at[k] + ((c - at[k]) * this.zoom) / zoom);
    this.zoom = zoom;
    if (zoom === 1) this.centre = [0.5, 0.5];
    else this.look(centre);
  }

  // as an address has it
  set(zoom, centre) {
    [this.zoom, this.centre] = [1, [0.5, 0.5]];
    this.near(zoom);
    this.look(centre);
  }

  // the centre stays inside the arena
  look(centre) {
    if (this.zoom > 1) this.centre = centre.map((c) => Math.min(Math.max(c, 0), 1));
  }

  // by shares of the visible width
  move(right, down) {
    this.look([this.centre[0] + right / this.zoom, this.centre[1] + down / this.zoom]);
  }
}
