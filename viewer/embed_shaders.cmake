# cmake -D OUTPUT=x.cpp -D FILES=a;b -P embed_shaders.cmake: the files as built_in_shaders() of viewer/shader.h.
set(table "")
foreach(file IN LISTS FILES)
  file(READ ${file} text)
  cmake_path(GET file FILENAME name)
  string(APPEND table "        {\"${name}\", R\"glsl(${text})glsl\"},\n")
endforeach()
file(
  WRITE ${OUTPUT}
  "#include \"viewer/shader.h\"

namespace lightgrid {

const ShaderSources& built_in_shaders() {
    static const ShaderSources sources = {
${table}    };
    return sources;
}

}  // namespace lightgrid
")
