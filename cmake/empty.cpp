// What a library of headers alone is made of.
