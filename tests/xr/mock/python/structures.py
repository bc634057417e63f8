"""Defines C structures in one line each. They can start with a type tag and a chain pointer, as in OpenXR and Vulkan."""

from ctypes import POINTER, Array, Structure, c_int32, c_void_p, cast, pointer


def struct(tag=None, **fields):
    """A structure with these fields. With a tag it starts with `type` and `next`, and `type` is set to the tag."""
    head = [] if tag is None else [("type", c_int32), ("next", c_void_p)]

    class Struct(Structure):
        _fields_ = head + list(fields.items())

        def __init__(self, *values, **named):
            if tag is not None:
                named.setdefault("type", tag)
                super().__init__(named.pop("type"), named.pop("next", None), *values)
                for name, value in named.items():
                    setattr(self, name, value)
            else:
                super().__init__(*values, **named)

        def __repr__(self):
            return ", ".join(f"{name}={getattr(self, name)}" for name, *_ in self._fields_)

    Struct.tag = tag
    return Struct


def address(value):
    """The address of a value or array, for a field that may point to anything. Keeps the value alive."""
    return cast(value if isinstance(value, Array) else pointer(value), c_void_p)


def array(kind, values):
    """Values as a C array, for a field or an argument that points to `kind`."""
    values = list(values)
    return (kind * len(values))(*values)


def declare(function, result, arguments):
    """Structures and simple values named as arguments are passed by address, `...Value` types by value."""
    function.restype = result
    function.argtypes = arguments
    return function


P = POINTER
