// One HTML file that works offline: node build.mjs [-o OUT.html] [FILE.glb ...]; files are put into the page.
import { readFile, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import esbuild from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url)), require = createRequire(import.meta.url);
const words = process.argv.slice(2);
let output = join(here, 'viewer.html');
const files = [];
while (words.length > 0) {
  const word = words.shift();
  if (word === '-o') output = words.shift();
  else files.push(word);
}
const bundle = await esbuild.build({
  entryPoints: [join(here, 'src/viewer.js')], bundle: true, minify: true, format: 'esm', write: false, target: 'es2022', legalComments: 'inline',
});
const dracoFolder = dirname(require.resolve('draco3d/package.json'));
const dracoScript = await readFile(join(dracoFolder, 'draco_decoder_nodejs.js'), 'utf8');
const dracoWasm = (await readFile(join(dracoFolder, 'draco_decoder.wasm'))).toString('base64');
const safe = (script) => script.replaceAll('</script', '<\\/script');
const data = await Promise.all(files.map(async (file) => (await readFile(file)).toString('base64')));
const start = `
window.phizDraco = () => new Promise((done) => DracoDecoderModule({
  wasmBinary: Uint8Array.from(atob("${dracoWasm}"), (c) => c.charCodeAt(0)), onModuleLoaded: (module) => done({ ...module, then: undefined }),
}));
window.phizFiles = ${JSON.stringify(data)};`;
const page = (await readFile(join(here, 'index.html'), 'utf8')).replace(
  '<script type="module">/*VIEWER*/</script>',
  () => `<script>${safe(dracoScript)}</script>\n<script>${safe(start)}</script>\n<script type="module">${safe(bundle.outputFiles[0].text)}</script>`,
);
await writeFile(output, page);
console.log(`${output}: ${page.length} bytes`);
