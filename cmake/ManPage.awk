# SPDX-License-Identifier: BSD-3-Clause
# Makes a program's manual page of its --help, and of that of each of its commands:
#   awk -v program=build/bin/kdstream-store -v version=0.9.0 -f ManPage.awk > kdstream-store.1
# What it goes by is what filters/program/HelpFormatter.h writes: "Usage:", headings that end with a colon, rows of two
# columns, the second of which begins after 30 characters, and at last the examples.

BEGIN {
  name = program
  sub(/.*\//, "", name)
  column = 30
  count = ReadHelp("")
  Open()
  Body(".SH", ".SS", 0)
  for (c = 1; c <= commands; ++c) {
    if (c == 1) print ".SH COMMANDS"
    count = ReadHelp(command[c])
    print ".SS " Text(command[c])
    Body("", ".PP\n.B", 1)
  }
  Close()
}

# The lines of a help text.
function ReadHelp(of,    call, lines) {
  call = "'" program "' " of " --help"
  while ((call | getline line[lines + 1]) > 0) ++lines
  if (close(call) != 0 || lines == 0) {
    print "ManPage.awk: no help of " name " " of > "/dev/stderr"
    exit 1
  }
  return lines
}

function Open(    sentence) {
  print ".\\\" Made of the program's --help."
  printf ".TH %s 1 \"\" \"KdStream %s\" \"User Commands\"\n", toupper(Text(name)), version
  print ".SH NAME"
  sentence = line[1]
  for (i = 2; sentence !~ /\.( |$)/ && line[i] != ""; ++i) sentence = sentence " " line[i]
  sub(/\.( .*)?$/, "", sentence)
  print Text(name) " \\- " Text(tolower(substr(sentence, 1, 1)) substr(sentence, 2))
}

function Close() {
  print ".SH EXIT STATUS\n.TP\n0\ndone\n.TP\n1\nthe work failed\n.TP\n2\nwrong usage"
}

# One help text: its sections under headings that begin with `section`, its groups with `group`.
function Body(section, group, isCommand,    i, part, last, heading) {
  for (i = 1; i <= count && line[i] !~ /^Usage: /; ++i) description[i] = line[i]
  part = i
  if (!isCommand) print section " SYNOPSIS"
  if (isCommand) print ".PP"
  heading = substr(line[part], 8)
  for (last = part; line[last + 1] != ""; ) heading = heading " " line[++last] # a long one goes on
  print ".B " Text(heading)
  if (!isCommand) print section " DESCRIPTION"
  if (isCommand) print ".PP"
  for (i = 1; i < part; ++i) {
    # A line that is short was ended by who wrote it, the others by their length.
    if (line[i] != "") print Text(line[i]) (i + 1 < part && length(line[i]) < 85 ? "\n.br" : "")
  }
  if (!isCommand) print section " OPTIONS"
  for (i = last + 1; i <= count; ++i) {
    if (line[i] ~ /^Examples?:$/) {
      if (isCommand) print group " Examples"
      else print section " EXAMPLES"
      print ".PP\n.nf"
      while (++i <= count) print Text(substr(line[i], 3))
      print ".fi"
    } else if (line[i] ~ /^Commands:$/) {
      heading = "commands"
    } else if (line[i] ~ /:$/ && line[i] !~ /^ /) {
      heading = line[i]
      sub(/:$/, "", heading)
      print group " " Text(heading)
    } else if (line[i] == "" && heading == "commands") {
      heading = ""
    } else if (heading == "commands" && line[i] ~ /^  [a-z]/) {
      split(line[i], word, " ")
      command[++commands] = word[1]
    } else if (heading != "commands" && line[i] ~ /^[^ ]/) { # what is said of them all
      if (line[i - 1] == "") print ".PP"
      print Text(line[i])
    } else if (heading != "commands" && line[i] != "") {
      Row(line[i])
    }
  }
}

# A row, or what goes on in its second column.
function Row(text,    first) {
  if (text ~ /^ +$/) return
  if (substr(text, 1, column) ~ /^ *$/) {
    print Text(substr(text, column + 1))
    return
  }
  first = substr(text, 3)
  if (match(first, /  +/)) {
    print ".TP\n.B " Text(substr(first, 1, RSTART - 1))
    print Text(substr(first, RSTART + RLENGTH))
  } else {
    print ".TP\n.B " Text(first)
  }
}

# Nothing in it means anything to roff.
function Text(text) {
  gsub(/\\/, "\\e", text)
  gsub(/-/, "\\-", text)
  sub(/^[.']/, "\\\\\\&&", text)
  return text
}
