# What a header says of itself in its first comment, as Doxygen's text of the file: lines indented by two or more beyond the text
# are code or formulas and stand as they are.
FNR == 1 { heading = 1; code = 0; open = "/** @file\n" }
heading && /^\/\// {
  text = substr($0, 3)
  indented = text ~ /^   / || (code && text ~ /^ *$/)
  mark = ""
  if (indented && !code) mark = "@verbatim "
  if (!indented && code) mark = "@endverbatim "
  code = indented
  print open mark text
  open = ""
  next
}
heading {
  print (code ? "@endverbatim " : "") "*/" $0
  heading = 0
  next
}
{ print }
