#!/usr/bin/zsh -f
# usage: complete.zsh FOLDER LINE EXPECTED...
# Types LINE and a tab into an interactive zsh with the completion of FOLDER/conddp, and waits until
# every expected text has appeared. Prints the output; fails after ten seconds.
zmodload zsh/zpty zsh/datetime
folder=$1 line=$2
shift 2
zpty shell zsh -f -i
trap 'zpty -d shell' EXIT
# The quotes keep the echo of this line from looking like the answer.
zpty -w shell "PATH=${(q)folder}:\$PATH TERM=dumb PS1='> ' LISTMAX=0; autoload -Uz compinit; \
compinit -u -D; source <(conddp completion zsh); setopt no_list_beep; print loa''ded"
zpty -r -m shell text '*loaded*' || exit 1
zpty -w -n shell $line$'\t'
text=''
deadline=$((EPOCHREALTIME + 10))
while ((EPOCHREALTIME < deadline)); do
  zpty -r -t shell chunk && text+=$chunk || sleep 0.02
  missing=0
  for word in "$@"; do [[ $text == *$word* ]] || missing=1; done
  ((missing)) || break
done
print -r -- $text
exit $missing
