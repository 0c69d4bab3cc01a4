#pragma once

/// Before a hot function of plain loops: compiled for AVX2 as well, chosen when the program starts. Without
/// contraction of multiplications and additions (-ffp-contract=off) both versions give the same bits. Nothing
/// elsewhere, and nothing under sanitizers, whose start-up comes after the choice.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PHIZ_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define PHIZ_VECTOR_CLONES
#endif
