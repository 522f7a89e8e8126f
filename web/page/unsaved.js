// What was bred, loved or drawn in a concert and no file has.

/** The actions that make such things. */
const MAKING = ["breed", "mutate", "favorite", "rename", "set-transfer", "set-amplification", "set-item-gain", "set-stereo-mu"];

export class Unsaved {
  /** How often something was made. */
  edits = 0;
  /** How many of the edits another gallery leaves: those of favorites. */
  staying = 0;

  /** An action that the concert has taken. */
  did(action) {
    if (MAKING.includes(action)) this.edits++;
    if (action === "favorite") this.staying++;
  }

  /** Whether another gallery would lose dances. */
  inGallery() {
    return this.edits > this.staying;
  }

  /** Another gallery was begun, to which favorites came along or not. */
  begunAnew(withFavorites) {
    // No file may have the favorites yet.
    this.staying = this.edits = withFavorites ? this.edits : 0;
  }
}
