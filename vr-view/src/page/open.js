// Another file: named by its path below a folder, chosen, or dropped on the page and sent in pieces.

import { ask } from "./connection.js";
import { isLocal } from "./local.js";

const byId = (id) => document.getElementById(id);

/** Bytes of a piece. */
const PIECE = 4 * 1024 * 1024;
/** Ends of names of files that describe others beside them. */
const HEADERS = [".mhd", ".nhdr", ".hdr", ".xmf", ".xdmf", ".pvd", ".pvti", ".pvtu", ".vtm", ".dat"];

/** A size in words. */
function size(bytes) {
  const units = ["bytes", "kB", "MB", "GB", "TB"];
  let power = 0;
  while (bytes >= 1000 && power + 1 < units.length) [bytes, power] = [bytes / 1000, power + 1];
  return `${power ? Number(bytes.toPrecision(3)) : bytes} ${units[power]}`;
}

export class OpenPanel {
  /** `failed(text)` is told why a file was not opened. */
  constructor({ failed }) {
    this.failed = failed;
    this.busy = false;
    this.listing = null;
    byId("open-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.path(byId("open-path").value.trim());
    });
    byId("open-files").addEventListener("change", ({ target }) => {
      this.files([...target.files]);
      target.value = "";
    });
    byId("section-open").addEventListener("toggle", () => this.list());
    // A drag over the page shows that a file may be dropped.
    let depth = 0;
    const shows = (by) => {
      depth = Math.max(depth + by, 0);
      byId("drop").hidden = depth === 0;
    };
    const hasFiles = (event) => this.listing?.opens && event.dataTransfer?.types.includes("Files");
    window.addEventListener("dragenter", (event) => hasFiles(event) && shows(1));
    window.addEventListener("dragleave", (event) => hasFiles(event) && shows(-1));
    window.addEventListener("dragover", (event) => hasFiles(event) && event.preventDefault());
    window.addEventListener("drop", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      depth = 0;
      byId("drop").hidden = true;
      this.files([...event.dataTransfer.files]);
    });
    this.list();
  }

  say(text) {
    byId("open-text").textContent = text;
  }

  /** Asks which files can be opened. */
  async list() {
    const response = await ask("files").catch(() => null);
    if (!response?.ok) return;
    this.listing = await response.json();
    const { opens, has_folder: hasFolder, files, max_upload: maxUpload } = this.listing;
    byId("section-open").hidden = !opens;
    byId("open-form").hidden = !hasFolder;
    byId("open-paths").replaceChildren(...files.map((value) => Object.assign(document.createElement("option"), { value })));
    if (!this.busy && byId("open-text").textContent === "") this.say(this.hint(hasFolder, maxUpload));
  }

  hint(hasFolder, maxUpload) {
    const folder = hasFolder || isLocal ? "" : " With vr view --folder FOLDER, files below it are opened by their paths.";
    return `Choose a file, or drop it on the page: ${size(maxUpload)} at most; several that belong together at once. Curve, light and camera are kept.${folder}`;
  }

  /** Sends a request; throws what it answers in words. */
  async request(address, options) {
    const response = await ask(address, options);
    if (!response.ok) throw new Error((await response.text()).trim() || `the program answers ${response.status}`);
    return response;
  }

  /** Does something that opens a file, one at a time, and says how it went. */
  async doing(name, act) {
    if (this.busy) return;
    this.busy = true;
    for (const id of ["open-path", "open-files", "open-button"]) byId(id).disabled = true;
    try {
      await act();
      this.say(`${name} is open; undo comes back to the file before.`);
    } catch (error) {
      this.say(`${name}: ${error.message}`);
      this.failed(`${name}: ${error.message}`);
    }
    for (const id of ["open-path", "open-files", "open-button"]) byId(id).disabled = false;
    this.busy = false;
  }

  /** Opens a file below the folder. */
  path(path) {
    if (!path) return undefined;
    return this.doing(path, () => {
      this.say(`${path} is read`);
      return this.request(`open?${new URLSearchParams({ path })}`, { method: "POST" });
    });
  }

  /** Sends files, and opens the one that describes the others, or all of them as a series. */
  files(files) {
    if (files.length === 0) return undefined;
    const header = files.find(({ name }) => HEADERS.some((end) => name.toLowerCase().endsWith(end)));
    const first = files.length === 1 ? files[0] : header;
    const name = first?.name ?? "";
    const bytes = files.reduce((sum, file) => sum + file.size, 0);
    return this.doing(name || `${files.length} files`, async () => {
      const { id } = await (await this.request(`upload?${new URLSearchParams({ bytes })}`, { method: "POST" })).json();
      try {
        let sent = 0;
        for (const file of files) {
          // An empty file is sent, too.
          for (let offset = 0; offset === 0 || offset < file.size; offset += PIECE) {
            const query = new URLSearchParams({ name: file.name, offset });
            await this.request(`upload/${id}?${query}`, { method: "POST", body: file.slice(offset, offset + PIECE) });
            sent += Math.min(PIECE, file.size - offset);
            this.say(`${size(sent)} of ${size(bytes)} are sent`);
          }
        }
        this.say("the file is read");
      } catch (error) {
        await ask(`upload/${id}`, { method: "DELETE" }).catch(() => null);
        throw error;
      }
      await this.request(`upload/${id}/open?${new URLSearchParams({ name })}`, { method: "POST" });
    });
  }
}
