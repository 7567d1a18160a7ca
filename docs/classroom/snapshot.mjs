// Write the memory of a Python that has imported what draws sheets, so that a browser need not start it anew:
// node snapshot.mjs SITE
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { promisify } from "node:util";
import { gzip } from "node:zlib";

const site = path.resolve(process.argv[2]);
const { loadPyodide } = await import(pathToFileURL(path.join(site, "pyodide", "pyodide.mjs")).href);
const python = await loadPyodide({ indexURL: path.join(site, "pyodide") + path.sep, _makeSnapshot: true });
const memory = python._module.HEAP8.length;
const archive = await readFile(path.join(site, "phaseplane.zip"));
python.unpackArchive(new Uint8Array(archive), "zip");
python.runPython("from phaseplane.scenarios.draw.classroom import answered");
const snapshot = python.makeMemorySnapshot();
// a browser begins with the memory that Python begins with here, and loads no more into it
if (python._module.HEAP8.length > memory) throw new Error("what draws sheets no longer fits into Python's first memory");
await writeFile(path.join(site, "python.gz.bin"), await promisify(gzip)(snapshot));
