"""build.py native|wide HEADER OUT.c: writes the extension's C source, cffi in API mode against the limited ABI."""

import re
import sys

import cffi

module, header, out = sys.argv[1:]
with open(header, encoding="utf-8") as file:
    declarations = re.sub(r"^\s*#.*$|///.*$", "", file.read(), flags=re.M)
builder = cffi.FFI()
builder.cdef(declarations)
if module == "native":
    builder.cdef('extern "Python" bool native_go_on(void);')
builder.set_source(f"tribo._{module}", f'#include "{header}"')
builder.emit_c_code(out)
