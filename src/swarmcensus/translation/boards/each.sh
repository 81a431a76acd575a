# This ${what}, one after another; `sh ${name} 3 7` only for robots 3 and 7.
from="$$PWD"
cd "$$(dirname "$$0")" || exit
known=" ${known} "
for one in "$$@"; do
    case "$$known" in *" $$one "*) ;; *) echo "there is no robot $$one, but:$$known" >&2; exit 2 ;; esac
done
wanted=" $$* "
failed=""

one() {  # number, port, address
    case "$$wanted" in *" $$1 "* | "  ") ;; *) return 0 ;; esac
    echo "robot $$1"
    (
    set -e  # what fails ends this robot's turn
    ${does}
    )
    [ $$? = 0 ] || failed="$$failed $$1"
}

${robots}

if [ -n "$$failed" ]; then
    echo "these robots failed, the others are done:$$failed" >&2
    exit 1
fi
