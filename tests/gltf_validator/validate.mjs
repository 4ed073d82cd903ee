// Prints the reports of Khronos' glTF validator on the files named, as one JSON list.
import { readFileSync } from "node:fs";
import { validateBytes } from "gltf-validator";

const reports = process.argv.slice(2).map((path) => validateBytes(new Uint8Array(readFileSync(path)), { maxIssues: 0 }));
console.log(JSON.stringify(await Promise.all(reports)));
