# Writes ${OUTPUT}: a C++ source that defines `std::map<std::string, std::string> firn::${NAME}()`, each of
# ${FILES} (separated by |) under its file name.
#   cmake -DNAME=shader_sources -DFILES=a.vert|b.frag -DOUTPUT=out.cpp -P embed.cmake
string(REPLACE "|" ";" files "${FILES}")
set(entries "")
foreach(file IN LISTS files)
    get_filename_component(name "${file}" NAME)
    file(READ "${file}" hex HEX)
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "\\\\x\\1" bytes "${hex}")
    # A literal may not be longer than 65 536 characters: pieces of 512 bytes are joined by the compiler.
    string(REGEX REPLACE "((\\\\x[0-9a-f][0-9a-f])+)" "\\1" bytes "${bytes}")
    string(LENGTH "${bytes}" length)
    set(pieces "")
    set(at 0)
    while(at LESS length)
        string(SUBSTRING "${bytes}" ${at} 2048 piece)
        string(APPEND pieces "\n        \"${piece}\"")
        math(EXPR at "${at} + 2048")
    endwhile()
    math(EXPR size "${length} / 4")
    string(APPEND entries "    {\"${name}\", std::string(${pieces},\n        ${size})},\n")
endforeach()
file(WRITE "${OUTPUT}" "#include <map>\n#include <string>\n\nnamespace firn {\n
std::map<std::string, std::string> ${NAME}();
std::map<std::string, std::string> ${NAME}() {\n    return {\n${entries}    };\n}\n\n}  // namespace firn\n")
