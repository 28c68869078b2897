# Writes OUT, a C++ source that holds text files: cmake -DFILES="a.gp;b.html" -DOUT=... -DSOURCE=... -P
# embed.cmake It also holds the commit of the project's folder SOURCE, so that a result can say which code
# made it. OUT is rewritten only if it changes.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 OUTPUT_VARIABLE commit
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
set(text "#include <map>\n#include <stdexcept>\n#include <string>\n\nnamespace aberfit {\n\n\
const std::string& embedded_text(const std::string& name) {\n  static const std::map<std::string, std::string> texts = {")
foreach(file IN LISTS FILES)
  cmake_path(GET file FILENAME name)
  file(READ ${file} content)
  # Compilers accept string literals only up to 64 kB.
  string(LENGTH "${content}" length)
  string(APPEND text "\n{\"${name}\",")
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${content}" ${at} 16000 piece)
    string(APPEND text " R\"embedded(${piece})embedded\"")
    math(EXPR at "${at} + 16000")
  endwhile()
  string(APPEND text "},")
endforeach()
string(APPEND text "\n  };\n  return texts.at(name);\n}\n\nconst char* source_commit() { return \"${commit}\"; }\n\n\
}  // namespace aberfit\n")
file(WRITE ${OUT}.new "${text}")
file(COPY_FILE ${OUT}.new ${OUT} ONLY_IF_DIFFERENT)
