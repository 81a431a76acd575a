# Puts each robot's files onto it, one after another; `sh flash.sh 3 7` only those of robots 3 and 7.
set -e
cd "$$(dirname "$$0")"
wanted=" $$* "

one() {  # number, port, address
    case "$$wanted" in *" $$1 "* | "  ") ;; *) return 0 ;; esac
    echo "robot $$1"
    ${flash}
}

${robots}
