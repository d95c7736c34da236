# cmake -D SCRIPT=... -D OUT=... -P embed.cmake: peer.mjs as a string literal of C++.
file(READ ${SCRIPT} content)
string(APPEND text "// The text of peer.mjs, as embed.cmake found it.\n#include \"tool/box2d3/box2d3_script.h\"\n\n"
  "namespace ticktrue::tool {\n\nconst std::string_view box2d3_script = R\"peer(${content})peer\";\n\n"
  "}  // namespace ticktrue::tool\n")
file(WRITE ${OUT} "${text}")
