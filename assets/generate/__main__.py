# SPDX-License-Identifier: Apache-2.0
"""Makes the meshes in rooms/ and instruments/ (binary glTF, metres): `python3 assets/generate [object ...]`. Same
script, same bytes; takes half a minute."""
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
