# cmake -DINPUT=... -DOUTPUT=... -DNAME=... -P DiffsacEmbed.cmake: a C++ file with the text of a file as diffsac::NAME.
file(READ ${INPUT} text)
set(end ")diffsac_end\"")
string(FIND "${text}" "${end}" found)
if(NOT found EQUAL -1)
  message(FATAL_ERROR "${INPUT} holds ${end}, which would end the string")
endif()
file(WRITE ${OUTPUT} "namespace diffsac {\nextern const char ${NAME}[];\nconst char ${NAME}[] = R\"diffsac_end(${text}${end};\n}\n")
