#!/bin/sh
# Manual pages from what the programs say with --help: one for each program and each command.
#   man_pages.sh VERSION FOLDER PROGRAM...
set -eu
version=$1 folder=$2
shift 2
mkdir -p "$folder"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cat >"$scratch/common" <<'EOF'
[EXIT STATUS]
0: done. 1: it failed, or the answer is a refusal. 2: usage or bad input.

[NOTES]
Units are mm, N, MPa and s; positions are in the patient frame LPS of DICOM. Research software, not a medical device.
EOF

# help2man wants options written "-h, --help" and two blanks before their meaning; examples are shown line by line below.
said() {
  sed -e '/^Example: /d' -e '/^         retractor/d' -e 's/^  -h,--help /  -h, --help/' \
    -e 's/^\(  --[a-z-]* [A-Z:]*\) \([A-Z][a-z]\)/\1  \2/' -e 's/:{[^}]\{60,\}}//' -e 's/{false}//' -e 's/ REQUIRED\( \|$\)/ (required)\1/' \
    -e 's/^Usage: [^ ]*\/\([^ /]*\)/Usage: \1/' "$1"
}
examples() {
  sed -n -e 's/^Example: *//p' -e 's/^         retractor/retractor/p' "$1" | sed 's/-/\\-/g'
}

# Commands below "Subcommands:", one a line.
commands_of() {
  sed -n '/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\) .*/\1/p' "$1"
}

# page TITLE PROGRAM [COMMAND...]: its page, and those of the commands below it, all at once.
page() (
  title=$1
  shift
  name=$(basename "$1")
  own="$scratch/$title"
  mkdir "$own"
  "$@" --help >"$own/raw"
  commands=$(commands_of "$own/raw")
  children=
  for command in $commands; do
    page "$title-$command" "$@" "$command" &
    children="$children $!"
  done
  about=$(sed -n '1s/\. .*//;1s/\.$//;1p' "$own/raw")
  # help2man runs a program: this one speaks for the command.
  said "$own/raw" >"$own/help"
  printf '#!/bin/sh\ncat "%s"\n' "$own/help" >"$own/program"
  chmod +x "$own/program"
  examples=$(examples "$own/raw")
  {
    cat "$scratch/common"
    [ -z "$examples" ] || printf '\n[EXAMPLES]\n.nf\n%s\n.fi\n' "$examples"
    [ "$title" = "$name" ] || printf '\n[SEE ALSO]\n.BR %s (1):\nthe options --json, --profile and --threads, which every command takes\n' "$name"
    if [ "$title" = "$name" ] && [ -n "$commands" ]; then
      printf '\n[SEE ALSO]\n'
      for command in $commands; do printf '.BR %s\\-%s (1),\n' "$name" "$command"; done
      printf '.BR retractor\\-workstation (1)\n'
    fi
  } >"$own/include"
  help2man --no-info --no-discard-stderr --include="$own/include" --version-string="$version" --name="$about" \
    --source="retractor $version" --manual="Retractor" "$own/program" >"$own/page"
  sed -e "s/^\.TH [^ ]*/.TH $(echo "$title" | tr '[:lower:]' '[:upper:]')/" -e '/^\.TH/a .nh\n.ad l' \
    -e "s/^program \\\\- /$(echo "$title" | sed 's/-/\\\\-/g') \\\\- /" \
    -e 's/^\.SS "Positionals:"/.SH ARGUMENTS/' -e 's/^\.SS "Subcommands:"/.SH COMMANDS/' "$own/page" >"$folder/$title.1"
  for child in $children; do wait "$child"; done
)

for program; do page "$(basename "$program")" "$program"; done
printf ".so man1/retractor.1\n" >"$folder/retractor-egl.1"
gzip -9nf "$folder"/*.1
