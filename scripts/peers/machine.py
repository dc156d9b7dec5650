"""What a comparison runs on."""

import platform


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as lines:
        return next((line.split(":")[1].strip() for line in lines
                     if line.startswith("model name")), platform.machine())
