// The canvas: shows pictures of any size over the whole stage, and tells how large it is.

/** Most pixels that are asked for. */
const MAX_PIXELS = 3840 * 2160 * 1.5;

/** Shows pictures on a canvas; `resized([width, height])` is called with its size in pixels of the screen. */
export class PictureView {
  constructor(canvas, resized) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false, desynchronized: false });
    this.small = document.createElement("canvas");
    this.size = [0, 0];
    this.head = null;
    const observer = new ResizeObserver(([entry]) => {
      const box = entry.devicePixelContentBoxSize?.[0];
      const ratio = window.devicePixelRatio;
      let width = box ? box.inlineSize : Math.round(entry.contentRect.width * ratio);
      let height = box ? box.blockSize : Math.round(entry.contentRect.height * ratio);
      const share = Math.min(1, Math.sqrt(MAX_PIXELS / Math.max(width * height, 1)));
      width = Math.max(1, Math.floor(width * share));
      height = Math.max(1, Math.floor(height * share));
      if (width === this.size[0] && height === this.size[1]) return;
      this.size = [width, height];
      // The old picture stays until the new one comes.
      const kept = document.createElement("canvas");
      kept.width = canvas.width;
      kept.height = canvas.height;
      kept.getContext("2d").drawImage(canvas, 0, 0);
      canvas.width = width;
      canvas.height = height;
      this.stretched(kept);
      resized(this.size);
    });
    try {
      observer.observe(canvas, { box: "device-pixel-content-box" });
    } catch {
      observer.observe(canvas);
    }
  }

  /** Height in heights of the picture: the middle is the middle, whatever the shape. */
  stretched(image) {
    const { width, height } = this.canvas;
    this.context.imageSmoothingEnabled = true;
    this.context.imageSmoothingQuality = "low";
    this.context.drawImage(image, 0, 0, width, height);
  }

  async show(head, bytes) {
    let image;
    const [width, height] = head.size;
    if (head.coding === "png") {
      const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }), { colorSpaceConversion: "none" });
      if (this.head && this.head.picture > head.picture) return false;
      image = bitmap;
    } else {
      const data = new ImageData(bytes, width, height);
      if (width === this.canvas.width && height === this.canvas.height) {
        this.context.putImageData(data, 0, 0);
        this.head = head;
        return true;
      }
      this.small.width = width;
      this.small.height = height;
      this.small.getContext("2d").putImageData(data, 0, 0);
      image = this.small;
    }
    this.stretched(image);
    this.head = head;
    return true;
  }
}
