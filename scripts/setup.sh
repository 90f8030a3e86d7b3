# Sourced by ./run, ./test and scripts/*: finds or installs what building and drawing need.
# Nothing is installed, and no rights are needed, where nothing is missing.
#
# After it: the working folder is the repository's root, `cargo` is on the path, a C++ compiler
# and a graphics driver are there, XDG_RUNTIME_DIR is set. Else it has said why and ended the
# script: status 1 for the build, 3 for graphics (as the program itself does).

cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "$*" >&2; }

# Installs Debian packages, or says what is needed and ends with the given status.
#   install_packages STATUS "what for" PACKAGE...
install_packages() {
    local status=$1 purpose=$2
    shift 2
    local root=()
    if ! command -v apt-get >/dev/null; then
        say "Missing: $purpose."
        say "This system is not known to the script; install what Debian calls: $*"
        exit "$status"
    fi
    if [ "$(id -u)" -ne 0 ]; then
        root=(sudo -n)
        if ! command -v sudo >/dev/null || ! sudo -n true 2>/dev/null; then
            say "Missing: $purpose. Run this, then try again:"
            say "  sudo apt-get install $*"
            exit "$status"
        fi
    fi
    say "Missing: $purpose. Installing $* with apt-get."
    # A fresh machine has no package lists yet; an old one may have stale ones.
    if ! { "${root[@]}" apt-get update -qq &&
        "${root[@]}" env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq --no-install-recommends "$@"; } >&2; then
        say "apt-get could not install $*."
        exit "$status"
    fi
}

need_rust() {
    local wanted found
    wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
    if ! command -v cargo >/dev/null && [ -x "$HOME/.cargo/bin/cargo" ]; then
        export PATH="$HOME/.cargo/bin:$PATH"
    fi
    if ! command -v cargo >/dev/null; then
        say "Missing: Rust $wanted or newer. Get it from https://rustup.rs"
        exit 1
    fi
    found=$(rustc --version | sed 's/^rustc \([0-9.]*\).*/\1/')
    if [ "$(printf '%s\n' "$wanted" "$found" | sort -V | head -n 1)" != "$wanted" ]; then
        say "Rust $wanted or newer is needed and $(command -v rustc) is $found."
        say "With rustup: rustup update stable; without: https://rustup.rs"
        exit 1
    fi
}

# meshopt and nv-flip are C++ inside.
need_compiler() {
    local compiler
    for compiler in "${CXX:-}" c++ g++ clang++; do
        if [ -n "$compiler" ] && command -v "$compiler" >/dev/null; then
            return
        fi
    done
    install_packages 1 "a C++ compiler" g++
}

# The manifests of Vulkan drivers, one a line: those that the loader would read.
vulkan_drivers() {
    local named=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}} file
    if [ -n "$named" ]; then
        tr ':' '\n' <<<"$named" | while read -r file; do
            if [ -f "$file" ]; then echo "$file"; elif [ -d "$file" ]; then ls "$file"/*.json; fi
        done
        return
    fi
    for file in /usr/share /usr/local/share /etc "${XDG_DATA_HOME:-$HOME/.local/share}"; do
        find "$file/vulkan/icd.d" -name '*.json' 2>/dev/null || true
    done
}

need_graphics() {
    # Metal and DirectX come with the system; another backend than Vulkan is the caller's choice.
    if [ "$(uname -s)" != Linux ]; then return; fi
    case ${WGPU_BACKEND:-vulkan} in *vulkan* | *vk*) ;; *) return ;; esac
    local drivers
    drivers=$(vulkan_drivers)
    if [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ]; then
        if [ -n "$drivers" ]; then return; fi
        say "No Vulkan driver: VK_DRIVER_FILES or VK_ICD_FILENAMES is set and names no file."
        exit 3
    fi
    # Without a GPU's device file the drivers of GPUs find nothing: a software one is needed.
    if ls /dev/dri/renderD* /dev/nvidiactl /dev/dxg >/dev/null 2>&1; then
        if [ -n "$drivers" ]; then return; fi
    elif grep -Eq 'lvp|lavapipe|swiftshader' <<<"$drivers"; then
        return
    fi
    install_packages 3 "a Vulkan driver" mesa-vulkan-drivers
}

# A window is opened on a display of its own, with what X libraries winit loads at run time.
need_display() {
    if [ "$(uname -s)" != Linux ]; then return; fi
    local library missing=no
    command -v Xvfb >/dev/null && command -v xdotool >/dev/null || missing=yes
    for library in libX11-xcb.so.1 libXcursor.so.1 libXi.so.6 libxkbcommon-x11.so.0; do
        /sbin/ldconfig -p 2>/dev/null | grep -q "$library" || missing=yes
    done
    if [ "$missing" = no ]; then return; fi
    install_packages 1 "an X server for the tests, and hands on it" xvfb xdotool libx11-xcb1 libxcursor1 libxi6 \
        libxkbcommon-x11-0
}

# The page is tested where the machine has a compiler for browsers; status 1 if it has not, or no browser.
want_browser() {
    scripts/check-wasm --can && command -v python3 >/dev/null || return 1
    if scripts/check-web --can; then return; fi
    # It may fail: the page is then not tested.
    (install_packages 1 "Chromium, for the test of the page" chromium)
    scripts/check-web --can
}

need_runtime_folder() {
    # The loader of Wayland's library complains aloud without one.
    if [ -z "${XDG_RUNTIME_DIR:-}" ]; then
        XDG_RUNTIME_DIR=$(mktemp -d)
        export XDG_RUNTIME_DIR
        trap 'rm -rf -- "$XDG_RUNTIME_DIR"' EXIT
    fi
}

need_rust
need_compiler
need_graphics
need_runtime_folder
