// Bundles field_view.js with vtk.js into one script, which begins with the licences of what it contains.

import { createHash } from 'node:crypto';
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const bundle = 'field_view.bundle.js';
const result = await build({
  entryPoints: ['field_view.js'],
  outfile: bundle,
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2020',
  legalComments: 'none',
  write: false,
  metafile: true,
});

const packages = new Set();
for (const file of Object.keys(result.metafile.inputs)) {
  const found = file.match(/^node_modules\/((?:@[^/]+\/)?[^/]+)\//);
  if (found) {
    packages.add(found[1]);
  }
}
const texts = [...packages].sort().map((name) => {
  const folder = `node_modules/${name}`;
  const { version, license } = JSON.parse(readFileSync(`${folder}/package.json`, 'utf8'));
  const file = readdirSync(folder).find((entry) => /^(licen[cs]e|copying)/i.test(entry));
  return `${name} ${version} (${license})\n\n${file ? readFileSync(`${folder}/${file}`, 'utf8').trim() : ''}\n`;
});
const licenses = texts.join(`\n${'-'.repeat(80)}\n\n`).replaceAll('*/', '* /');
const script = `/*\n${licenses}*/\n${result.outputFiles[0].text}`;
writeFileSync(bundle, script);

const hash = createHash('sha256').update(script).digest('hex');
writeFileSync(`${bundle}.sha256`, `${hash}  ${bundle}\n`);
