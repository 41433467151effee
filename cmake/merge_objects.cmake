# cmake -DOUTPUT=FILE -DINPUTS=FILE,... -DKEEP=PATTERN,... -DLINKER= -DOBJCOPY= -DNM= -P merge_objects.cmake
# One object of all inputs (objects and what of archives they need), in which every symbol is local but those that match KEEP (mangled, *).

function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

string(REPLACE "," ";" INPUTS "${INPUTS}")
string(REPLACE "," ";" KEEP "${KEEP}")

# Groups of inline functions are resolved here: as groups they would still be matched by name with those of the program.
run("${LINKER}" -r --force-group-allocation -o "${OUTPUT}" ${INPUTS})

# objcopy does not make local what gcc marks as unique in the process; weak symbols it does.
execute_process(COMMAND "${NM}" --defined-only --format=posix "${OUTPUT}" OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n ]+ u " unique "${symbols}")
list(TRANSFORM unique REPLACE " u " "\n")
list(JOIN unique "" unique)
file(WRITE "${OUTPUT}.unique" "${unique}")
run("${OBJCOPY}" "--weaken-symbols=${OUTPUT}.unique" "${OUTPUT}")

list(TRANSFORM KEEP PREPEND "--keep-global-symbol=")
run("${OBJCOPY}" --wildcard ${KEEP} "${OUTPUT}")
run("${OBJCOPY}" --localize-hidden --strip-unneeded "${OUTPUT}")
