# usage: bash --norc complete.bash FOLDER WORD...
# Prints the candidates of FOLDER/conddp's completion for the last word, one a line.
PATH=$1:$PATH
shift
source <(conddp completion bash)
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
function=$(complete -p conddp | sed 's/.*-F \([^ ]*\).*/\1/')
"$function"
((${#COMPREPLY[@]} == 0)) || printf '%s\n' "${COMPREPLY[@]}"
