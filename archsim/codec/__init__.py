"""Lossless compression of tiles of a depth buffer. [Lloyd07] sec. 4.3, [Hasselgren06]"""
