// Write the memory of a Python that has drawn the first sheet, so that a browser need not start it anew:
// node snapshot.mjs SITE
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { promisify } from "node:util";
import { gzip } from "node:zlib";

const site = path.resolve(process.argv[2]);
const { loadPyodide } = await import(pathToFileURL(path.join(site, "pyodide", "pyodide.mjs")).href);
const python = await loadPyodide({ indexURL: path.join(site, "pyodide") + path.sep, _makeSnapshot: true });
const archive = await readFile(path.join(site, "phaseplane.zip"));
python.unpackArchive(new Uint8Array(archive), "zip");
python.runPython("from phaseplane.scenarios.draw.classroom import answered");
const first = JSON.parse(await readFile(path.join(site, "first.json"), "utf8"));
python.globals.get("answered")(JSON.stringify({ what: "sheet", scene: first.scene, ...first.fields }));
await writeFile(path.join(site, "python.gz.bin"), await promisify(gzip)(python.makeMemorySnapshot()));
