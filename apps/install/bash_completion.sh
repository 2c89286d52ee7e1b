#!/usr/bin/env bash
# Prints the completion of bash for the program given, from its own --help. Use: apps/install/bash_completion.sh TRIBOTRACK
set -euo pipefail
program=${1:?the program}

# "  run       From recordings to ..." below "Subcommands:".
commands=$("$program" --help | awk '/^Subcommands:/ { on = 1; next } on && /^  [a-z]/ { print $1 } on && /^$/ { exit }')
[ -n "$commands" ]

echo '# bash completion for tribotrack'
echo '_tribotrack() {'
echo '  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= options= one'
echo '  for one in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do'
echo '    case $one in -*) ;; *) command=$one; break ;; esac'
echo '  done'
echo '  case $command in'
echo '    ""|help) COMPREPLY=($(compgen -W "help campaign '$commands' --version --help" -- "$word")); return ;;'
for command in $commands; do
  # "  -o,--output FILE REQUIRED  ...": the names, and the words of a value such as auto|on|off; capitals stand for a value.
  "$program" "$command" --help | awk -v command="$command" '
    /^  -/ {
      names = $1; gsub(",", "|", names)
      all = all " " $1
      value = $2; words = ""
      count = value ~ /\|/ ? split(value, parts, "|") : 0
      for (k = 1; k <= count; ++k) if (parts[k] !~ /[A-Z,.]/) words = words " " parts[k]
      if (words != "") choices = choices "        " names ") COMPREPLY=($(compgen -W \"" substr(words, 2) "\" -- \"$word\")); return ;;\n"
    }
    END {
      gsub(",", " ", all)
      printf "    %s)\n", command
      if (choices != "") printf "      case $before in\n%s      esac\n", choices
      printf "      options=\"%s\" ;;\n", substr(all, 2)
    }'
done
cat <<'END'
  esac
  case $word in
    -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;;
    *) COMPREPLY=($(compgen -f -- "$word")); compopt -o filenames 2>/dev/null ;;
  esac
}
complete -F _tribotrack tribotrack
END
