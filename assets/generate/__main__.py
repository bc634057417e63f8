# SPDX-License-Identifier: Apache-2.0
"""Writes the meshes in rooms/ and instruments/ (binary glTF, metres): `python3 assets/generate [object ...]`. The same
script always writes the same bytes. Takes half a minute."""
import sys

import c_arm
import hand
import instruments
import lamps
import machines
import shell
import table

MAKERS = {"table": table, "c_arm": c_arm, "machines": machines, "lamps": lamps, "shell": shell,
          "instruments": instruments, "hand": hand}

if __name__ == "__main__":
    for name in sys.argv[1:] or MAKERS:
        MAKERS[name].make()
