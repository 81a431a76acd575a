# This ${what}, one after another; `sh ${name} 3 7` only for robots 3 and 7.
set -e
from="$$PWD"
cd "$$(dirname "$$0")"
known=" ${known} "
for one in "$$@"; do
    case "$$known" in *" $$one "*) ;; *) echo "there is no robot $$one, but:$$known" >&2; exit 2 ;; esac
done
wanted=" $$* "

one() {  # number, port, address
    case "$$wanted" in *" $$1 "* | "  ") ;; *) return 0 ;; esac
    echo "robot $$1"
    ${does}
}

${robots}
