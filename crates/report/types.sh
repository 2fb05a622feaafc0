#!/usr/bin/env bash
# The types of the page's script, which its comments state, by TypeScript.
set -euo pipefail
cd "$(dirname "$0")/src/page"
npx --yes -p typescript@7.0.2 tsc --allowJs --checkJs --strict --noEmit --target es2022 --lib es2022,dom,dom.iterable drawing.js script.js
