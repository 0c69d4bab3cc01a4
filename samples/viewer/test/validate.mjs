// gltf-validator over files: node test/validate.mjs FILE... ; prints a line a file, ends with 1 on any error or warning.
import { readFile } from 'node:fs/promises';
import validator from 'gltf-validator';

let worst = 0;
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)));
  const { numErrors, numWarnings, messages } = report.issues;
  console.log(`${numErrors} errors ${numWarnings} warnings ${file}`);
  for (const message of messages) if (message.severity < 2) console.log(`  ${message.code} ${message.pointer}: ${message.message}`);
  worst = Math.max(worst, numErrors + numWarnings);
}
process.exit(worst === 0 ? 0 : 1);
