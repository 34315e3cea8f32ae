/* sha256, with the names of FIPS 180-4, section 6.2; for equations_fit.c.
 *
 * urdf2mbs writes this file anew at each conversion: do not edit it. */
#ifndef EQUATIONS_FIT_SHA256_h
#define EQUATIONS_FIT_SHA256_h

#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef struct Sha256 {
    uint32_t H[8];
    unsigned char block[64];
    uint64_t n_bytes;
} Sha256;

static const uint32_t K[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2,
};

static uint32_t rotate_right(uint32_t x, int n)
{
    return x >> n | x << (32 - n);
}

static void hash_block(Sha256 *sha)
{
    uint32_t W[64], s[8];

    for (int t = 0; t < 16; t++) {
        const unsigned char *word = sha->block + 4 * t;
        W[t] = 0;
        for (int k = 0; k < 4; k++) {
            W[t] = W[t] << 8 | word[k];
        }
    }
    for (int t = 16; t < 64; t++) {
        uint32_t x = W[t - 15], y = W[t - 2];
        uint32_t sigma0 = rotate_right(x, 7) ^ rotate_right(x, 18) ^ x >> 3;
        uint32_t sigma1 = rotate_right(y, 17) ^ rotate_right(y, 19) ^ y >> 10;
        W[t] = sigma1 + W[t - 7] + sigma0 + W[t - 16];
    }
    memcpy(s, sha->H, sizeof s); /* a, b, ..., h */
    for (int t = 0; t < 64; t++) {
        uint32_t a = s[0], e = s[4];
        uint32_t Sigma1 = rotate_right(e, 6) ^ rotate_right(e, 11) ^ rotate_right(e, 25);
        uint32_t Sigma0 = rotate_right(a, 2) ^ rotate_right(a, 13) ^ rotate_right(a, 22);
        uint32_t Ch = (e & s[5]) ^ (~e & s[6]);
        uint32_t Maj = (a & s[1]) ^ (a & s[2]) ^ (s[1] & s[2]);
        uint32_t T1 = s[7] + Sigma1 + Ch + K[t] + W[t];
        memmove(s + 1, s, 7 * sizeof s[0]);
        s[4] += T1;
        s[0] = T1 + Sigma0 + Maj;
    }
    for (int k = 0; k < 8; k++) {
        sha->H[k] += s[k];
    }
}

static void start_hash(Sha256 *sha)
{
    static const uint32_t H0[8] = {
        0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
        0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19,
    };

    memcpy(sha->H, H0, sizeof H0);
    sha->n_bytes = 0;
}

static void hash_bytes(Sha256 *sha, const char *bytes, size_t length)
{
    for (size_t k = 0; k < length; k++) {
        sha->block[sha->n_bytes++ % 64] = (unsigned char) bytes[k];
        if (sha->n_bytes % 64 == 0) {
            hash_block(sha);
        }
    }
}

static void finish_hash(Sha256 *sha, char checksum[65])
{
    uint64_t n_bits = 8 * sha->n_bytes;

    hash_bytes(sha, "\x80", 1);
    while (sha->n_bytes % 64 != 56) {
        hash_bytes(sha, "", 1);
    }
    for (int k = 7; k >= 0; k--) {
        char byte = (char) (n_bits >> 8 * k & 0xff);
        hash_bytes(sha, &byte, 1);
    }
    for (int k = 0; k < 8; k++) {
        snprintf(checksum + 8 * k, 9, "%08lx", (unsigned long) sha->H[k]);
    }
}

#endif
